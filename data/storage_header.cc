#include "data/storage_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "data/input_error.h"

namespace sinew::storage {
namespace {

using text::Line;
using text::LineReader;
using Cells = std::vector<std::string_view>;

// One header line `key=value` or, as SIMM writes it, `key value`.
struct HeaderLine {
  std::string_view whole, key, value;
  std::string word;  // the key in lower case
  bool has_equals = false;
  int number = 0;
};

[[noreturn]] void fail(const std::string& path, int line, InputError::Parts parts) {
  throw InputError({path, line}, std::move(parts));
}

HeaderLine parse_header_line(const Line& line) {
  HeaderLine result;
  result.number = line.number;
  result.whole = text::trim(line.text);
  const std::size_t end = std::min(result.whole.find_first_of(" \t="), result.whole.size());
  result.key = result.whole.substr(0, end);
  result.word = text::lower(result.key);
  result.has_equals = end < result.whole.size() && result.whole[end] == '=';
  const std::size_t value = result.whole.find_first_not_of(" \t=", end);
  if (value != result.whole.npos) result.value = result.whole.substr(value);
  return result;
}

bool is_row_count(const std::string& word) {
  return word == "nrows" || word == "nr" || word == "datarows";
}
bool is_column_count(const std::string& word) {
  return word == "ncolumns" || word == "nc" || word == "datacolumns";
}
// Keys whose meaning the other fields of a TimeTable carry, or that follow from the data.
bool is_structural(const std::string& word) {
  static constexpr std::array kWords = {"name",      "version",   "indegrees", "datatype",
                                        "endheader", "otherdata", "range"};
  return is_row_count(word) || is_column_count(word) ||
         std::find(kWords.begin(), kWords.end(), word) != kWords.end();
}

std::optional<Promise> parse_promise(const std::string& path, const HeaderLine& line) {
  const std::optional<long long> count = text::parse_integer(line.value);
  if (!count || *count < 0) {
    fail(path, line.number,
         {fmt::format("the header's {} is no count", line.key), "a whole number, 0 or more",
          std::string(line.value), "Correct it; the rows of the file itself decide."});
  }
  return Promise{std::string(line.key), *count, line.number};
}

bool parse_in_degrees(const std::string& path, const HeaderLine& line) {
  const std::string word = text::lower(line.value);
  for (const char* yes : {"yes", "y", "true", "1"}) {
    if (word == yes) return true;
  }
  for (const char* no : {"no", "n", "false", "0"}) {
    if (word == no) return false;
  }
  fail(path, line.number,
       {"the header's inDegrees is neither yes nor no", "yes or no", std::string(line.value),
        "Write inDegrees=yes if angles are in degrees, inDegrees=no for radians."});
}

void apply_header_line(const std::string& path, const HeaderLine& line, bool first,
                       Header& header) {
  if (is_row_count(line.word)) {
    header.rows = parse_promise(path, line);
  } else if (is_column_count(line.word)) {
    header.columns = parse_promise(path, line);
  } else if (line.word == "indegrees") {
    header.in_degrees = parse_in_degrees(path, line);
  } else if (line.word == "version") {
    header.has_version = true;
  } else if (line.word == "datatype") {
    header.data_type = line.value;
    header.data_type_line = line.number;
  } else if (line.word == "name") {
    if (first) header.name = line.value;
  } else if (line.whole == "Angles are in degrees.") {
    header.angles_in_degrees = true;
  } else if (line.has_equals && !is_structural(line.word)) {
    header.other[std::string(line.key)] = line.value;
  } else if (first && !is_structural(line.word)) {
    header.name = line.whole;
  }
}

// Labels may hold spaces where tabs separate them; old files separate them by either. The count in
// the header, then the first row of data decide.
Cells split_labels(const Line& line, const std::optional<Promise>& promise, LineReader lines) {
  Cells words, cells, row;
  text::split_words(line.text, words);
  text::split_tabs(line.text, cells);
  std::erase(cells, std::string_view{});
  if (words.size() == cells.size() || cells.size() < 2) return words;
  const auto promised = promise ? static_cast<std::size_t>(promise->count) : 0;
  if (promised == words.size()) return words;
  if (promised == cells.size()) return cells;
  if (const std::optional<Line> first = lines.next_filled()) text::split_words(first->text, row);
  return row.size() == words.size() ? words : cells;
}

}  // namespace

Header parse_header(const std::string& path, LineReader& lines) {
  Header header;
  bool first = true;
  int count = 0;
  for (std::optional<Line> next = lines.next(); next; next = lines.next()) {
    count = next->number;
    const HeaderLine line = parse_header_line(*next);
    if (line.whole.empty()) continue;
    if (line.word == "endheader") return header;
    apply_header_line(path, line, first, header);
    first = false;
  }
  fail(path, 0,
       {"the header has no end", "a line 'endheader'", fmt::format("none in {} lines", count),
        "Is it a MOT or STO file, and is it complete?"});
}

std::vector<std::string> element_suffixes(const std::string& path, const Header& header) {
  const std::string type = text::lower(header.data_type);
  if (type == "double" || type == "float" || type.empty()) return {""};
  if (type == "vec3" || type == "unitvec3") return {"_x", "_y", "_z"};
  if (type == "spatialvec") return {"_rx", "_ry", "_rz", "_tx", "_ty", "_tz"};
  std::optional<long long> size;
  if (type == "quaternion") size = 4;
  if (type.starts_with("vec")) size = text::parse_integer(std::string_view(type).substr(3));
  if (!size || *size < 2 || *size > 12) {
    fail(path, header.data_type_line,
         {"the header's DataType is not known",
          "double, Vec2 to Vec12, UnitVec3, Quaternion or SpatialVec", header.data_type,
          "Export the table as plain numbers."});
  }
  std::vector<std::string> suffixes;
  for (long long i = 1; i <= *size; ++i) suffixes.push_back(fmt::format("_{}", i));
  return suffixes;
}

Columns parse_columns(const std::string& path, const Header& header, LineReader& lines) {
  const std::optional<Line> line = lines.next_filled();
  if (!line) {
    fail(path, 0,
         {"has no column labels", "a line of labels after 'endheader'", "the end of the file",
          "Was the file written completely?"});
  }
  const Cells cells = split_labels(*line, header.columns, lines);
  Columns columns{{cells.begin(), cells.end()}, cells.size(), line->number};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (!text::equals_ignoring_case(cells[i], "time")) continue;
    if (columns.time < cells.size()) {
      fail(path, line->number,
           {"two columns are called time", "one",
            fmt::format("columns {} and {}", columns.time + 1, i + 1), "Remove or rename one."});
    }
    columns.time = i;
  }
  if (columns.time == cells.size()) {
    fail(path, line->number,
         {"no column is called time", "the label 'time' among the column labels",
          std::string(text::trim(line->text)), "Add the time of every row, in seconds."});
  }
  return columns;
}

bool reads_as_key(const std::string& name) {
  const HeaderLine line = parse_header_line({name, 1, true});
  return line.has_equals || is_structural(line.word);
}

bool is_structural_key(std::string_view key) { return is_structural(text::lower(key)); }

}  // namespace sinew::storage
