#include "data/storage_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "data/numbers.h"
#include "data/open_end.h"
#include "data/output_file.h"
#include "data/storage_header.h"
#include "data/text.h"

namespace sinew {
namespace {

using storage::Columns;
using storage::Header;
using storage::Promise;
using text::Line;
using text::LineReader;
using Cells = std::vector<std::string_view>;

[[noreturn]] void fail(const std::string& path, int line, InputError::Parts parts) {
  throw InputError({path, line}, std::move(parts));
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
           {"the time is no number", "a time in seconds", std::string(cell),
            text::remedy_for_number(cell)});
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
          "a number", std::string(cell), text::remedy_for_number(cell)});
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
    out += fmt::format("{}{}\n", storage::reads_as_key(table.name) ? "name " : "", table.name);
  }
  out +=
      fmt::format("version=1\nnRows={}\nnColumns={}\n", table.time.size(), table.labels.size() + 1);
  if (table.in_degrees) out += fmt::format("inDegrees={}\n", *table.in_degrees ? "yes" : "no");
  for (const auto& [key, value] : table.header) {
    if (!storage::is_structural_key(key)) out += fmt::format("{}={}\n", key, value);
  }
  out += "endheader\ntime";
  for (const std::string& label : table.labels) out += "\t" + label;
  return out + "\n";
}

}  // namespace

TimeTableFile read_storage(const std::filesystem::path& path) {
  const std::string content = text::read_text_file(path, "a MOT or STO file");
  TimeTableFile file;
  file.path = path.string();
  LineReader lines(content);
  const Header header = storage::parse_header(file.path, lines);
  const std::vector<std::string> suffixes = storage::element_suffixes(file.path, header);
  const Columns columns = storage::parse_columns(file.path, header, lines);
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
  warn_of_open_end(file.path, content, file.warnings);
  return file;
}

std::vector<std::string> read_storage_labels(const std::filesystem::path& path) {
  const std::string content = text::read_text_file(path, "a MOT or STO file");
  LineReader lines(content);
  const Header header = storage::parse_header(path.string(), lines);
  const std::vector<std::string> suffixes = storage::element_suffixes(path.string(), header);
  return flat_labels(storage::parse_columns(path.string(), header, lines), suffixes);
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
