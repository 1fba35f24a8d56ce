#include "data/trc_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "data/input_file.h"
#include "data/output_file.h"
#include "data/text.h"

namespace sinew {
namespace {

using text::Line;
using text::LineReader;
using Cells = std::vector<std::string_view>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kLeadingCells = 2;  // Frame# and Time

[[noreturn]] void fail(const std::string& path, int line, InputError::Parts parts) {
  throw InputError({path, line}, std::move(parts));
}

struct Header {
  double rate = 0.0;                  // [Hz]
  long long frames = 0, markers = 0;  // as promised
  int decimal_shift = 0;              // powers of ten from the file's unit to metres
  int line = 0;                       // of the values
};

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

struct Layout {
  std::size_t markers = 0;
  bool tabs = true;
  int decimal_shift = 0;
};

// Collects rows; each is checked before the next is read.
class RowParser {
 public:
  RowParser(const std::string& path, const Layout& layout, const std::vector<std::string>& names)
      : path_(path), layout_(layout), names_(names), width_(kLeadingCells + 3 * layout.markers) {}

  void parse(const Line& line) {
    split(line);
    frames_.push_back(parse_frame(line));
    times_.push_back(parse_time(line));
    for (std::size_t marker = 0; marker < layout_.markers; ++marker) parse_marker(line, marker);
  }

  void fill(MarkerTrajectories& markers) const {
    const auto rows = static_cast<Eigen::Index>(times_.size());
    markers.frame_numbers = frames_;
    markers.time = Eigen::Map<const Eigen::VectorXd>(times_.data(), rows);
    markers.p_WM = Eigen::Map<const RowMatrix>(p_WM_.data(), rows,
                                               static_cast<Eigen::Index>(3 * layout_.markers));
  }

  void add_warnings(std::vector<Warning>& warnings) const {
    for (const Tally* tally : {&zeros_, &partial_, &short_rows_}) {
      if (tally->count == 0) continue;
      warnings.push_back(
          {{path_, tally->line}, fmt::format(fmt::runtime(tally->text), tally->count)});
    }
  }

 private:
  // How often something odd was seen, and first on which line.
  struct Tally {
    const char* text;
    long long count = 0;
    int line = 0;

    void add(int at) {
      if (count++ == 0) line = at;
    }
  };

  void split(const Line& line) {
    const bool tabs = layout_.tabs && line.text.find('\t') != line.text.npos;
    tabs ? text::split_tabs(line.text, cells_) : text::split_words(line.text, cells_);
    while (cells_.size() > width_ && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() == width_) return;
    // Spreadsheets leave out the tabs behind the last filled cell.
    const bool whole_markers =
        cells_.size() >= kLeadingCells && (cells_.size() - kLeadingCells) % 3 == 0;
    if (tabs && cells_.size() < width_ && whole_markers && line.terminated) {
      short_rows_.add(line.number);
      // Half of what is kept may be padding, else short rows under a huge header would ask for more
      // memory than the file's size warrants.
      padding_ += width_ - cells_.size();
      if (padding_ <= p_WM_.size() / 2 + kFreePadding) return cells_.resize(width_);
    }
    fail_row(line);
  }

  [[noreturn]] void fail_row(const Line& line) const {
    fail(path_, line.number,
         {"a row does not fit the markers",
          fmt::format("{} values: frame, time and three for each of {} markers", width_,
                      layout_.markers),
          fmt::format("{}", cells_.size()),
          line.terminated ? "Correct the row or the header."
                          : "It is the last row: was the file written completely?"});
  }

  int parse_frame(const Line& line) const {
    const std::optional<long long> frame = text::parse_integer(cells_[0]);
    if (frame && std::abs(*frame) <= std::numeric_limits<int>::max()) {
      return static_cast<int>(*frame);
    }
    fail(path_, line.number,
         {"the frame number is no whole number", "a frame number", std::string(cells_[0]),
          "Correct the first cell of the row."});
  }

  double parse_time(const Line& line) const {
    const std::optional<double> time = text::parse_number(cells_[1]);
    if (!time || !std::isfinite(*time)) {
      fail(path_, line.number,
           {"the time is no number", "a time in seconds", std::string(cells_[1]),
            remedy_for(cells_[1])});
    }
    if (!times_.empty() && *time <= times_.back()) {
      fail(path_, line.number,
           {"time does not increase",
            fmt::format("more than {} s, the time of the row before",
                        text::format_number(times_.back())),
            std::string(cells_[1]), "Remove repeated rows and sort the others by time."});
    }
    return *time;
  }

  void parse_marker(const Line& line, std::size_t marker) {
    std::array<double, 3> p;
    int missing = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p[axis] = parse_coordinate(line, marker, axis);
      if (std::isnan(p[axis])) ++missing;
    }
    const bool zero = p[0] == 0.0 && p[1] == 0.0 && p[2] == 0.0;
    if (zero) zeros_.add(line.number);
    if (missing == 1 || missing == 2) partial_.add(line.number);
    if (zero || missing > 0) p.fill(kNaN);
    p_WM_.insert(p_WM_.end(), p.begin(), p.end());
  }

  double parse_coordinate(const Line& line, std::size_t marker, std::size_t axis) const {
    const std::string_view cell = cells_[kLeadingCells + 3 * marker + axis];
    if (cell.empty()) return kNaN;
    const std::optional<double> value = text::parse_number(cell, layout_.decimal_shift);
    if (value && !std::isinf(*value)) return *value;
    fail(path_, line.number,
         {fmt::format("{} of marker '{}' is no number", "XYZ"[axis], names_[marker]),
          "a position, NaN or a blank cell", std::string(cell), remedy_for(cell)});
  }

  static std::string remedy_for(std::string_view cell) {
    return cell.find(',') == cell.npos ? "Correct the value."
                                       : "Write decimals with a point, not a comma.";
  }

  static constexpr std::size_t kFreePadding = 1 << 20;  // cells, 8 MiB

  const std::string& path_;
  const Layout layout_;
  const std::vector<std::string>& names_;
  const std::size_t width_;
  Cells cells_;
  std::size_t padding_ = 0;
  std::vector<int> frames_;
  std::vector<double> times_, p_WM_;
  Tally zeros_{"{} marker samples at exactly 0, 0, 0 were read as not measured"};
  Tally partial_{"{} marker samples lack one or two coordinates and were read as not measured"};
  Tally short_rows_{"{} rows end early; their last markers were read as not measured"};
};

std::string read_text(const std::filesystem::path& path) {
  std::string content = read_file(path);
  if (text::trim(content).empty()) {
    fail(path.string(), 0, {"is empty", "a TRC file", "", "Was it written completely?"});
  }
  if (text::looks_binary(content)) {
    fail(path.string(), 0,
         {"is binary or UTF-16", "a TRC file in plain text", "",
          "Is it the right file? Save it as UTF-8 text."});
  }
  return content;
}

void warn_of_header(const Header& header, MarkerFile& file) {
  const MarkerTrajectories& markers = file.markers;
  const auto warn = [&](std::string text) {
    file.warnings.push_back({{file.path, header.line}, std::move(text)});
  };
  if (header.frames != markers.frame_count()) {
    warn(
        fmt::format("the header promises NumFrames={}, the file has {} frames; all of them were "
                    "read",
                    header.frames, markers.frame_count()));
  }
  if (header.markers != markers.marker_count()) {
    warn(
        fmt::format("the header promises NumMarkers={}, the file has {} markers; all of them "
                    "were read",
                    header.markers, markers.marker_count()));
  }
  const Eigen::Index steps = markers.time.size() - 1;
  if (steps < 1) return;
  const double measured = static_cast<double>(steps) / (markers.time[steps] - markers.time[0]);
  // 2 % lets times pass that are rounded to milliseconds over a few frames; doubled and decimated
  // recordings are off by far more.
  if (std::abs(measured / header.rate - 1.0) > 0.02) {
    warn(fmt::format("the header's DataRate is {} Hz, the times step at {:.6g} Hz", header.rate,
                     measured));
  }
}

// Reads the names and the labels X1 Y1 Z1 ..., which some writers leave out.
Layout parse_columns(const Header& header, LineReader& lines, MarkerFile& file,
                     std::optional<Line>& first_row) {
  const NameLine names =
      parse_name_line(file.path, require_line(file.path, lines, "the line of marker names"));
  first_row = lines.next_filled();
  std::size_t labels = first_row ? count_coordinate_labels(first_row->text) : 0;
  if (labels % 3 != 0) {
    fail(file.path, first_row->number,
         {"the coordinate labels are incomplete", "X, Y and Z for every marker",
          fmt::format("{} labels", labels), "Correct the header."});
  }
  if (labels > 0) first_row = lines.next_filled();
  if (!first_row) {
    fail(file.path, 0,
         {"has no rows of data", "at least one frame", "", "Was the file written completely?"});
  }
  const std::size_t triples = labels > 0 ? labels / 3 : names.names.size();
  match_names(file.path, names, triples, filled_cells(first_row, names.tabs), file);
  make_names_unique(file.path, names.line, file);
  return {triples, names.tabs, header.decimal_shift};
}

void check_writable(const std::string& path, const MarkerTrajectories& markers) {
  const Eigen::Index frames = markers.time.size();
  const auto columns = static_cast<Eigen::Index>(3 * markers.names.size());
  if (markers.p_WM.rows() != frames || markers.p_WM.cols() != columns ||
      static_cast<Eigen::Index>(markers.frame_numbers.size()) != frames) {
    fail(path, 0,
         {"write_trc got trajectories whose sizes disagree",
          fmt::format("{} frames, {} × {} positions", frames, frames, columns),
          fmt::format("{} frame numbers, {} × {} positions", markers.frame_numbers.size(),
                      markers.p_WM.rows(), markers.p_WM.cols()),
          ""});
  }
  for (const std::string& name : markers.names) {
    if (!text::trim(name).empty() && name.find_first_of("\t\r\n") == name.npos) continue;
    fail(path, 0,
         {"write_trc cannot write this marker name", "a name without tabs and line breaks", name,
          "Rename the marker."});
  }
}

std::string format_header(const std::string& file_name, const MarkerTrajectories& markers) {
  const std::string rate = text::format_number(markers.rate);
  const int first = markers.frame_numbers.empty() ? 1 : markers.frame_numbers.front();
  std::string out = fmt::format("PathFileType\t4\t(X/Y/Z)\t{}\n", file_name);
  out +=
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
      "OrigNumFrames\n";
  out += fmt::format("{0}\t{0}\t{1}\t{2}\tmm\t{0}\t{3}\t{1}\nFrame#\tTime", rate,
                     markers.frame_count(), markers.marker_count(), first);
  for (const std::string& name : markers.names) out += "\t" + name + "\t\t";
  out += "\n\t";
  for (int i = 1; i <= markers.marker_count(); ++i) out += fmt::format("\tX{0}\tY{0}\tZ{0}", i);
  return out + "\n\n";
}

}  // namespace

MarkerFile read_trc(const std::filesystem::path& path) {
  const std::string content = read_text(path);
  MarkerFile file;
  file.path = path.string();
  LineReader lines(content);
  const Header header = parse_header(file.path, lines);
  file.markers.rate = header.rate;
  std::optional<Line> line;
  const Layout layout = parse_columns(header, lines, file, line);
  RowParser rows(file.path, layout, file.markers.names);
  for (; line; line = lines.next_filled()) rows.parse(*line);
  rows.fill(file.markers);
  warn_of_header(header, file);
  rows.add_warnings(file.warnings);
  return file;
}

void write_trc(const std::filesystem::path& path, const MarkerTrajectories& markers) {
  check_writable(path.string(), markers);
  std::string out = format_header(path.filename().string(), markers);
  for (Eigen::Index row = 0; row < markers.p_WM.rows(); ++row) {
    out += fmt::format("{}\t{}", markers.frame_numbers[static_cast<std::size_t>(row)],
                       text::format_number(markers.time[row]));
    for (const double coordinate : markers.p_WM.row(row)) {
      out += '\t';
      if (!std::isnan(coordinate)) out += text::format_number(coordinate, 3);
    }
    // OpenSim counts a blank cell at the end of a row only if a tab follows it.
    if (out.back() == '\t') out += '\t';
    out += '\n';
  }
  write_file_atomically(path, out);
}

}  // namespace sinew
