#include "data/trc_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

namespace sinew::trc {
namespace {

using text::Line;
using text::LineReader;
using Cells = std::vector<std::string_view>;

[[noreturn]] void fail(const std::string& path, int line, InputError::Parts parts) {
  throw InputError({path, line}, std::move(parts));
}

Line require_line(const std::string& path, LineReader& lines, const char* what) {
  if (const std::optional<Line> line = lines.next_filled()) return *line;
  fail(path, 0,
       {fmt::format("ends before {}", what), "a complete TRC header and rows of data", "",
        "Was the file written completely?"});
}

int decimal_shift_of_unit(const std::string& path, int line, const std::string& unit) {
  const std::string word = text::lower(unit);
  constexpr std::array kMetres = {"m", "meter", "meters", "metre", "metres"};
  const auto is = [&](const char* prefix, const char* symbol) {
    return word == symbol || std::any_of(kMetres.begin() + 1, kMetres.end(), [&](const char* name) {
             return word == std::string(prefix) + name;
           });
  };
  if (is("", "m")) return 0;
  if (is("centi", "cm")) return -2;
  if (is("milli", "mm")) return -3;
  fail(path, line,
       {"the header's Units are not known", "mm, cm or m", unit,
        "Write the unit of the marker positions."});
}

// The header's values by key. Writers pad them with blanks and doubled tabs, so they are paired in
// order unless a blank one between single tabs makes the pairing by cell the only one that fits.
class HeaderValues {
 public:
  HeaderValues(const std::string& path, const Line& keys, const Line& values)
      : path_(path), line_(values.number) {
    text::split_words(keys.text, keys_);
    text::split_words(values.text, values_);
    if (values_.size() >= keys_.size()) return;
    Cells cells;
    text::split_tabs(values.text, cells);
    while (!cells.empty() && cells.back().empty()) cells.pop_back();
    if (cells.size() <= keys_.size() && cells.size() > values_.size()) values_ = cells;
  }

  std::string_view text(const char* key) const {
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      if (!text::equals_ignoring_case(keys_[i], key)) continue;
      return i < values_.size() ? values_[i] : std::string_view{};
    }
    fail(path_, line_ - 1,
         {fmt::format("the header has no {}", key), "DataRate, NumFrames, NumMarkers and Units", "",
          "Add the field."});
  }

  long long count(const char* key) const {
    const std::optional<long long> value = text::parse_integer(text(key));
    if (value && *value >= 0) return *value;
    fail(path_, line_,
         {fmt::format("the header's {} is no count", key), "a whole number, 0 or more",
          std::string(text(key)), "Correct it; the rows of the file itself decide."});
  }

  double rate() const {
    const std::optional<double> value = text::parse_number(text("DataRate"));
    if (value && std::isfinite(*value) && *value > 0.0) return *value;
    fail(path_, line_,
         {"the header's DataRate is no rate", "frames per second, above 0",
          std::string(text("DataRate")), "Write the rate of the recording."});
  }

 private:
  const std::string& path_;
  int line_;
  Cells keys_, values_;
};

// The line of marker names. Most writers leave three cells to a marker, some two; `standard` says
// that each name stands over its marker's first coordinate.
struct NameLine {
  std::vector<std::string> names;
  std::vector<std::size_t> slots;  // the marker a name stands over, where standard
  bool standard = true;
  bool tabs = true;
  int line = 0;
};

NameLine parse_name_line(const std::string& path, const Line& line) {
  NameLine result;
  result.line = line.number;
  result.tabs = line.text.find('\t') != line.text.npos;
  Cells cells;
  result.tabs ? text::split_tabs(line.text, cells) : text::split_words(line.text, cells);
  const bool frame = text::lower(cells.front()).starts_with("frame");
  if (!frame || cells.size() < kLeadingCells || !text::lower(cells[1]).starts_with("time")) {
    fail(path, line.number,
         {"the line of marker names is missing", "'Frame#', 'Time' and names",
          std::string(text::trim(line.text)), "Correct the header."});
  }
  result.standard = result.tabs;
  for (std::size_t i = kLeadingCells; i < cells.size(); ++i) {
    if (cells[i].empty()) continue;
    result.names.emplace_back(cells[i]);
    result.slots.push_back((i - kLeadingCells) / 3);
    if ((i - kLeadingCells) % 3 != 0) result.standard = false;
  }
  if (result.names.empty()) {
    fail(path, line.number,
         {"the file names no marker", "marker names after 'Time'", "",
          "Label the markers and export the file again."});
  }
  return result;
}

bool is_coordinate_label(std::string_view word) {
  return word.size() >= 2 && std::string_view("XYZxyz").find(word.front()) != word.npos &&
         word.find_first_not_of("0123456789", 1) == word.npos;
}

// Number of labels X1 Y1 Z1 X2 ... in the line, 0 if it is no line of labels.
std::size_t count_coordinate_labels(std::string_view line) {
  Cells words;
  text::split_words(line, words);
  return std::all_of(words.begin(), words.end(), is_coordinate_label) ? words.size() : 0;
}

// Cells up to the last filled one.
std::size_t filled_cells(const std::optional<Line>& line, bool tabs) {
  if (!line) return 0;
  Cells cells;
  tabs ? text::split_tabs(line->text, cells) : text::split_words(line->text, cells);
  while (!cells.empty() && cells.back().empty()) cells.pop_back();
  return cells.size();
}

// Gives every triple of coordinates a name.
void match_names(const std::string& path, const NameLine& line, std::size_t triples,
                 std::size_t row_cells, MarkerFile& file) {
  const std::size_t named = line.names.size();
  const bool fits = row_cells <= kLeadingCells + 3 * triples;
  const auto warn = [&](std::string text) {
    file.warnings.push_back({{path, line.line}, std::move(text)});
  };
  if (named == triples || (named > triples && line.standard && fits)) {
    file.markers.names.assign(line.names.begin(),
                              line.names.begin() + static_cast<std::ptrdiff_t>(triples));
    if (named > triples) {
      warn(fmt::format("{} names for {} triples of coordinates; the last names were left out",
                       named, triples));
    }
    return;
  }
  if (named > triples || !line.standard || line.slots.back() >= triples) {
    fail(path, line.line,
         {"marker names and coordinates do not match",
          fmt::format("{} names, one for each triple of coordinates", triples),
          fmt::format("{}", named), "Name every marker, with one tab between the cells."});
  }
  file.markers.names.assign(triples, "");
  for (std::size_t i = 0; i < named; ++i) file.markers.names[line.slots[i]] = line.names[i];
  warn(fmt::format("{} markers have no name; they are called unnamed_1, unnamed_2, ...",
                   triples - named));
}

// Names must be unique to be found again; the first of a kind keeps its name.
void make_names_unique(const std::string& path, int line, MarkerFile& file) {
  std::vector<std::string>& names = file.markers.names;
  std::unordered_set<std::string> taken(names.begin(), names.end());
  std::unordered_set<std::string> seen;
  int unnamed = 0;
  // Continues counting for every name, so that thousands of equal names stay linear.
  std::unordered_map<std::string, int> copies;
  for (std::string& name : names) {
    const bool blank = name.empty();
    if (!blank && seen.insert(name).second) continue;
    const std::string base = blank ? "unnamed" : name;
    int& copy = blank ? unnamed : copies.emplace(name, 1).first->second;
    std::string unique;
    do unique = fmt::format("{}_{}", base, ++copy);
    while (!taken.insert(unique).second);
    if (!blank) {
      file.warnings.push_back({{path, line},
                               fmt::format("marker '{}' appears again; this one is "
                                           "called '{}'",
                                           name, unique)});
    }
    name = unique;
  }
}

}  // namespace

Header parse_header(const std::string& path, LineReader& lines) {
  const Line first = require_line(path, lines, "the line 'PathFileType'");
  if (!text::trim(first.text).starts_with("PathFileType")) {
    fail(path, first.number,
         {"is no TRC file", "'PathFileType' at its beginning", std::string(text::trim(first.text)),
          "Is it the right file?"});
  }
  const Line keys = require_line(path, lines, "the header's field names");
  const Line values = require_line(path, lines, "the header's values");
  const HeaderValues fields(path, keys, values);
  Header header;
  header.rate = fields.rate();
  header.frames = fields.count("NumFrames");
  header.markers = fields.count("NumMarkers");
  header.decimal_shift =
      decimal_shift_of_unit(path, values.number, std::string(fields.text("Units")));
  header.line = values.number;
  return header;
}

Layout parse_columns(const Header& header, text::LineReader& lines, MarkerFile& file,
                     std::vector<std::string>* labels) {
  const NameLine names =
      parse_name_line(file.path, require_line(file.path, lines, "the line of marker names"));
  std::optional<Line> first_row = lines.next_filled();
  std::size_t axes = first_row ? count_coordinate_labels(first_row->text) : 0;
  if (axes % 3 != 0) {
    fail(file.path, first_row->number,
         {"the coordinate labels are incomplete", "X, Y and Z for every marker",
          fmt::format("{} labels", axes), "Correct the header."});
  }
  if (axes > 0) first_row = lines.next_filled();
  if (!first_row) {
    fail(file.path, 0,
         {"has no rows of data", "at least one frame", "", "Was the file written completely?"});
  }
  const std::size_t triples = axes > 0 ? axes / 3 : names.names.size();
  match_names(file.path, names, triples, filled_cells(first_row, names.tabs), file);
  if (labels) *labels = file.markers.names;
  make_names_unique(file.path, names.line, file);
  return {triples, names.tabs, header.decimal_shift, *first_row};
}

}  // namespace sinew::trc
