#include "data/csv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "data/numbers.h"
#include "data/open_end.h"
#include "data/output_file.h"
#include "data/text.h"

namespace sinew {
namespace {

constexpr const char* kTimeNames[] = {"time", "t", "time_s", "time [s]", "time(s)", "time (s)"};

[[noreturn]] void fail(const std::string& path, int line, InputError::Parts parts) {
  throw InputError({path, line}, std::move(parts));
}

// The one that the line of labels has most of, outside of quotes.
char separator_of(std::string_view line) {
  char best = ',';
  std::ptrdiff_t most = 0;
  for (const char candidate : {',', ';', '\t'}) {
    bool quoted = false;
    std::ptrdiff_t count = 0;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      if (c == candidate && !quoted) ++count;
    }
    if (count > most) {
      best = candidate;
      most = count;
    }
  }
  return best;
}

bool is_time(const std::string& label) {
  return std::any_of(std::begin(kTimeNames), std::end(kTimeNames),
                     [&](const char* name) { return text::equals_ignoring_case(label, name); });
}

class Parser {
 public:
  Parser(const std::string& path, const text::Line& labels)
      : path_(path), separator_(separator_of(labels.text)) {
    labels_ = csv_cells({path, labels.number}, labels.text, separator_);
    if (labels_.size() > 1 && labels_.back().empty()) labels_.pop_back();
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      if (is_time(labels_[i])) found.push_back(i);
      if (labels_[i].empty()) {
        fail(path, labels.number,
             {fmt::format("column {} has no label", i + 1), "a name", "", "Name it."});
      }
    }
    if (found.size() != 1) {
      fail(path, labels.number,
           {found.empty() ? "no column is the time" : "two columns are the time",
            "one column 'time' [s]", std::string(labels.text), "Name the columns in line 1."});
    }
    time_ = found.front();
  }

  void parse(const text::Line& line) {
    std::vector<std::string> cells = csv_cells({path_, line.number}, line.text, separator_);
    while (cells.size() > labels_.size() && cells.back().empty()) cells.pop_back();
    if (cells.size() != labels_.size()) {
      fail(path_, line.number,
           {"a row does not fit the column labels", fmt::format("{} cells", labels_.size()),
            fmt::format("{}", cells.size()),
            line.terminated ? "Correct the row or the labels."
                            : "It is the last row: was the file written completely?"});
    }
    parse_time(line, cells[time_]);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i != time_) values_.push_back(value(line, i, cells[i]));
    }
  }

  void fill(TimeTableFile& file) const {
    TimeTable& table = file.table;
    for (std::size_t i = 0; i < labels_.size(); ++i) {
      if (i != time_) table.labels.push_back(labels_[i]);
    }
    const auto rows = static_cast<Eigen::Index>(times_.size());
    table.time = Eigen::Map<const Eigen::VectorXd>(times_.data(), rows);
    table.values = Eigen::Map<const RowMatrix>(values_.data(), rows,
                                               static_cast<Eigen::Index>(table.labels.size()));
    if (blanks_ > 0) {
      file.warnings.push_back(
          {{path_, first_blank_}, fmt::format("{} blank cells were read as NaN", blanks_)});
    }
    const std::set<std::string> names(table.labels.begin(), table.labels.end());
    if (names.size() < table.labels.size()) {
      file.warnings.push_back(
          {{path_, 0},
           fmt::format("{} columns repeat the label of an earlier one; by name only the first of "
                       "each is found",
                       table.labels.size() - names.size())});
    }
  }

 private:
  // A comma is the decimal point where it does not separate cells.
  std::optional<double> number(std::string cell) const {
    if (separator_ != ',') std::replace(cell.begin(), cell.end(), ',', '.');
    return text::parse_number(cell);
  }

  void parse_time(const text::Line& line, const std::string& cell) {
    const std::optional<double> time = number(cell);
    if (!time || !std::isfinite(*time)) {
      fail(path_, line.number,
           {"the time is no number", "a time in seconds", cell, text::remedy_for_number(cell)});
    }
    if (!times_.empty() && *time < times_.back()) {
      fail(path_, line.number,
           {"time decreases",
            fmt::format("at least {} s, the time of the row before",
                        text::format_number(times_.back())),
            cell, "Sort the rows by time."});
    }
    times_.push_back(*time);
  }

  double value(const text::Line& line, std::size_t column, const std::string& cell) {
    if (cell.empty()) {
      if (blanks_++ == 0) first_blank_ = line.number;
      return kNaN;
    }
    if (const std::optional<double> value = number(cell)) return *value;
    fail(path_, line.number,
         {fmt::format("column '{}' has a value that is no number", labels_[column]), "a number",
          cell, text::remedy_for_number(cell)});
  }

  const std::string& path_;
  const char separator_;
  std::vector<std::string> labels_;
  std::size_t time_ = 0;
  std::vector<double> times_, values_;
  long long blanks_ = 0;
  int first_blank_ = 0;
};

void check_writable(const std::string& path, const TimeTable& table) {
  const auto columns = static_cast<Eigen::Index>(table.labels.size());
  if (table.values.cols() != columns || table.values.rows() != table.time.size()) {
    fail(path, 0,
         {"write_csv got a table whose sizes disagree",
          fmt::format("{} × {} values", table.time.size(), columns),
          fmt::format("{} × {}", table.values.rows(), table.values.cols()), ""});
  }
  for (const std::string& label : table.labels) {
    const bool one_line = label.find_first_of("\r\n") == label.npos;
    if (one_line && !text::trim(label).empty() && !is_time(label)) continue;
    fail(path, 0,
         {"write_csv cannot write this label", "a name in one line other than 'time'", label,
          "Rename the column."});
  }
}

}  // namespace

std::vector<std::string> csv_cells(const SourceLocation& at, std::string_view line,
                                   char separator) {
  std::vector<std::string> cells = {""};
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      cells.back() += line[i++];
    } else if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  if (quoted) {
    throw InputError(at,
                     {"a quote is not closed", "'\"' before the end of the line", "", "Close it."});
  }
  for (std::string& cell : cells) cell = std::string(text::trim(cell));
  return cells;
}

std::string csv_cell(const std::string& text) {
  const bool plain = text.find_first_of(",;\t\"\r\n") == text.npos && text::trim(text) == text;
  if (plain) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

TimeTableFile read_csv(const std::filesystem::path& path) {
  const std::string content = text::read_text_file(path, "a CSV file");
  TimeTableFile file;
  file.path = path.string();
  text::LineReader lines(content);
  const std::optional<text::Line> labels = lines.next_filled();
  if (!labels) {
    fail(file.path, 0,
         {"is empty", "a line of labels and rows of numbers", "", "Was it written completely?"});
  }
  Parser parser(file.path, *labels);
  while (const std::optional<text::Line> line = lines.next_filled()) parser.parse(*line);
  parser.fill(file);
  warn_of_open_end(file.path, content, file.warnings);
  return file;
}

void write_csv(const std::filesystem::path& path, const TimeTable& table) {
  check_writable(path.string(), table);
  std::string out = "time";
  for (const std::string& label : table.labels) out += "," + csv_cell(label);
  out += '\n';
  for (Eigen::Index row = 0; row < table.values.rows(); ++row) {
    out += text::format_number(table.time[row]);
    for (const double value : table.values.row(row)) {
      out += ',';
      if (!std::isnan(value)) out += text::format_number(value);
    }
    out += '\n';
  }
  write_file_atomically(path, out);
}

}  // namespace sinew
