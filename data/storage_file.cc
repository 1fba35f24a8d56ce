#include "data/storage_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <unordered_map>
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

// A count that the header promises, and where.
struct Promise {
  std::string key;
  long long count = 0;
  int line = 0;
};

struct Header {
  std::string name;
  std::optional<Promise> rows, columns;
  std::optional<bool> in_degrees;
  bool angles_in_degrees = false;  // the sentence, which counts only in files without `version`
  bool has_version = false;
  std::string data_type = "double";
  int data_type_line = 0;
  std::map<std::string, std::string> other;
};

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

// How many numbers one cell holds, and how their columns are told apart: as OpenSim flattens them.
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

struct Columns {
  std::vector<std::string> labels;  // one a cell, `time` included
  std::size_t time = 0;
  int line = 0;
};

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

// Collects rows; each is checked before the next is read.
class RowParser {
 public:
  RowParser(const std::string& path, const Columns& columns, std::size_t elements)
      : path_(path), columns_(columns), elements_(elements) {}

  void parse(const Line& line) {
    split(line);
    const double time = parse_time(line);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      if (i != columns_.time) parse_cell(line, i);
    }
    times_.push_back(time);
  }

  void fill(TimeTable& table) const {
    const auto rows = static_cast<Eigen::Index>(times_.size());
    const auto width = static_cast<Eigen::Index>((columns_.labels.size() - 1) * elements_);
    table.time = Eigen::Map<const Eigen::VectorXd>(times_.data(), rows);
    table.values = Eigen::Map<const RowMatrix>(values_.data(), rows, width);
  }

  void add_warnings(std::vector<Warning>& warnings) const {
    if (repeated_ > 0) {
      warnings.push_back(
          {{path_, first_repeated_},
           fmt::format("{} rows repeat the time of the row before; all are kept", repeated_)});
    }
    if (blanks_ > 0) {
      warnings.push_back(
          {{path_, first_blank_}, fmt::format("{} blank cells were read as NaN", blanks_)});
    }
  }

 private:
  void split(const Line& line) {
    const std::size_t width = columns_.labels.size();
    text::split_words(line.text, cells_);
    const std::size_t words = cells_.size();
    if (elements_ == 1 && words == width) return;
    text::split_tabs(line.text, cells_);
    const bool cut_short = !line.terminated && cells_.back().empty();
    while (cells_.size() > width && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() == width && !cut_short) return;
    const std::size_t found = elements_ == 1 ? words : cells_.size();
    fail(path_, line.number,
         {"a row does not fit the column labels",
          fmt::format("{} values, one for each label of line {}", width, columns_.line),
          fmt::format("{}", found),
          line.terminated ? "Correct the row or the labels."
                          : "It is the last row: was the file written completely?"});
  }

  double parse_time(const Line& line) {
    const std::string_view cell = cells_[columns_.time];
    const std::optional<double> time = text::parse_number(cell);
    if (!time || !std::isfinite(*time)) {
      fail(path_, line.number,
           {"the time is no number", "a time in seconds", std::string(cell), remedy_for(cell)});
    }
    if (!times_.empty() && *time < times_.back()) {
      fail(path_, line.number,
           {"time decreases",
            fmt::format("at least {} s, the time of the row before",
                        text::format_number(times_.back())),
            std::string(cell), "Sort the rows by time."});
    }
    if (!times_.empty() && *time == times_.back() && repeated_++ == 0) {
      first_repeated_ = line.number;
    }
    return *time;
  }

  void parse_cell(const Line& line, std::size_t column) {
    std::string_view rest = cells_[column];
    if (rest.empty()) {
      values_.insert(values_.end(), elements_, kNaN);
      if (blanks_++ == 0) first_blank_ = line.number;
      return;
    }
    if (elements_ == 1) return values_.push_back(parse_value(line, column, rest));
    std::size_t count = 0;
    for (bool more = true; more; ++count) {
      const std::size_t comma = rest.find(',');
      more = comma != rest.npos;
      const std::string_view element = text::trim(rest.substr(0, comma));
      if (count < elements_) values_.push_back(parse_value(line, column, element));
      if (more) rest.remove_prefix(comma + 1);
    }
    if (count == elements_) return;
    fail(path_, line.number,
         {fmt::format("column '{}' has a vector of the wrong size", columns_.labels[column]),
          fmt::format("{} numbers separated by commas", elements_), std::string(cells_[column]),
          "Correct the cell or the header's DataType."});
  }

  double parse_value(const Line& line, std::size_t column, std::string_view cell) const {
    if (const std::optional<double> value = text::parse_number(cell)) return *value;
    fail(path_, line.number,
         {fmt::format("column '{}' has a value that is no number", columns_.labels[column]),
          "a number", std::string(cell), remedy_for(cell)});
  }

  static std::string remedy_for(std::string_view cell) {
    return cell.find(',') == cell.npos ? "Correct the value."
                                       : "Write decimals with a point, not a comma.";
  }

  const std::string& path_;
  const Columns& columns_;
  const std::size_t elements_;
  Cells cells_;
  std::vector<double> times_, values_;
  long long repeated_ = 0, blanks_ = 0;
  int first_repeated_ = 0, first_blank_ = 0;
};

void warn_of_promises(const Header& header, std::size_t columns, std::size_t rows,
                      TimeTableFile& file) {
  const auto check = [&](const std::optional<Promise>& promise, std::size_t count,
                         const char* what) {
    if (!promise || promise->count == static_cast<long long>(count)) return;
    file.warnings.push_back({{file.path, promise->line},
                             fmt::format("the header promises {}={}, the file has {} {}; all of "
                                         "them were read",
                                         promise->key, promise->count, count, what)});
  };
  check(header.columns, columns, "columns");
  check(header.rows, rows, "rows");
}

void warn_of_duplicates(int line, TimeTableFile& file) {
  std::unordered_map<std::string_view, std::size_t> first;
  std::string examples;
  int count = 0;
  for (std::size_t i = 0; i < file.table.labels.size(); ++i) {
    const std::string& label = file.table.labels[i];
    if (first.emplace(label, i).second) continue;
    // Enough to see the pattern; a table may hold thousands.
    if (++count <= 3) examples += (count > 1 ? ", '" : "'") + label + "'";
  }
  if (count == 0) return;
  file.warnings.push_back(
      {{file.path, line},
       fmt::format("{} columns repeat the label of an earlier one ({}{}); by name only the first "
                   "of each is found",
                   count, examples, count > 3 ? ", ..." : "")});
}

std::string read_text(const std::filesystem::path& path) {
  std::string content = read_file(path);
  if (text::trim(content).empty()) {
    fail(path.string(), 0, {"is empty", "a MOT or STO file", "", "Was it written completely?"});
  }
  if (text::looks_binary(content)) {
    fail(path.string(), 0,
         {"is binary or UTF-16", "a MOT or STO file in plain text", "",
          "Is it the right file? Save it as UTF-8 text."});
  }
  return content;
}

std::vector<std::string> flat_labels(const Columns& columns,
                                     const std::vector<std::string>& suffixes) {
  std::vector<std::string> labels;
  for (std::size_t i = 0; i < columns.labels.size(); ++i) {
    if (i == columns.time) continue;
    for (const std::string& suffix : suffixes) labels.push_back(columns.labels[i] + suffix);
  }
  return labels;
}

void check_writable(const std::string& path, const TimeTable& table) {
  const auto columns = static_cast<Eigen::Index>(table.labels.size());
  if (table.values.cols() != columns || table.values.rows() != table.time.size()) {
    fail(path, 0,
         {"write_storage got a table whose sizes disagree",
          fmt::format("{} × {} values", table.time.size(), columns),
          fmt::format("{} × {}", table.values.rows(), table.values.cols()), ""});
  }
  const auto check = [&](const std::string& text, const char* what, const char* forbidden) {
    if (text.find_first_of(forbidden) == text.npos) return;
    fail(path, 0,
         {fmt::format("write_storage cannot write this {}", what),
          "text without tabs and line breaks", text, "Rename it."});
  };
  check(table.name, "name", "\r\n");
  for (const auto& [key, value] : table.header) {
    check(key, "header key", " =\t\r\n");
    check(value, "header value", "\r\n");
  }
  for (const std::string& label : table.labels) {
    check(label, "label", "\t\r\n");
    if (!text::trim(label).empty() && !text::equals_ignoring_case(label, "time")) continue;
    fail(path, 0,
         {"write_storage cannot write this label", "a name other than 'time'", label,
          "Rename the column."});
  }
}

std::string format_header(const TimeTable& table) {
  std::string out;
  if (!table.name.empty()) {
    const HeaderLine line = parse_header_line({table.name, 1, true});
    // Otherwise the first line would be read as a key.
    const bool ambiguous = line.has_equals || is_structural(line.word);
    out += fmt::format("{}{}\n", ambiguous ? "name " : "", table.name);
  }
  out +=
      fmt::format("version=1\nnRows={}\nnColumns={}\n", table.time.size(), table.labels.size() + 1);
  if (table.in_degrees) out += fmt::format("inDegrees={}\n", *table.in_degrees ? "yes" : "no");
  for (const auto& [key, value] : table.header) {
    if (!is_structural(text::lower(key))) out += fmt::format("{}={}\n", key, value);
  }
  out += "endheader\ntime";
  for (const std::string& label : table.labels) out += "\t" + label;
  return out + "\n";
}

}  // namespace

TimeTableFile read_storage(const std::filesystem::path& path) {
  const std::string content = read_text(path);
  TimeTableFile file;
  file.path = path.string();
  LineReader lines(content);
  const Header header = parse_header(file.path, lines);
  const std::vector<std::string> suffixes = element_suffixes(file.path, header);
  const Columns columns = parse_columns(file.path, header, lines);
  RowParser rows(file.path, columns, suffixes.size());
  while (const std::optional<Line> line = lines.next_filled()) rows.parse(*line);

  file.table.name = header.name;
  file.table.header = header.other;
  file.table.in_degrees = header.in_degrees;
  if (!header.in_degrees && !header.has_version && header.angles_in_degrees) {
    file.table.in_degrees = true;
  }
  file.table.labels = flat_labels(columns, suffixes);
  rows.fill(file.table);
  warn_of_promises(header, columns.labels.size(), file.table.time.size(), file);
  warn_of_duplicates(columns.line, file);
  rows.add_warnings(file.warnings);
  return file;
}

std::vector<std::string> read_storage_labels(const std::filesystem::path& path) {
  const std::string content = read_text(path);
  LineReader lines(content);
  const Header header = parse_header(path.string(), lines);
  const std::vector<std::string> suffixes = element_suffixes(path.string(), header);
  return flat_labels(parse_columns(path.string(), header, lines), suffixes);
}

void write_storage(const std::filesystem::path& path, const TimeTable& table) {
  check_writable(path.string(), table);
  std::string out = format_header(table);
  for (Eigen::Index row = 0; row < table.values.rows(); ++row) {
    out += text::format_number(table.time[row]);
    for (const double value : table.values.row(row)) {
      out += '\t';
      out += text::format_number(value);
    }
    out += '\n';
  }
  write_file_atomically(path, out);
}

}  // namespace sinew
