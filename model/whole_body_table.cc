#include "model/whole_body_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "data/text.h"

namespace sinew::anatomy {
namespace {

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (std::size_t begin = 0;;) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text::trim(text.substr(begin, end - begin)));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

// Where in `name` the letter of its side stands, or npos.
std::size_t side_letter(std::string_view name) {
  for (std::size_t i = name.size(); i-- > 1;) {
    const bool ends = i + 1 == name.size() || name[i + 1] == '_';
    if (ends && name[i - 1] == '_' && (name[i] == 'r' || name[i] == 'l')) return i;
  }
  return std::string_view::npos;
}

}  // namespace

std::string_view TableRow::cell(std::string_view column) const {
  const auto found = std::find(columns_->begin(), columns_->end(), column);
  if (found == columns_->end()) return {};
  return cells_[static_cast<std::size_t>(found - columns_->begin())];
}

std::string TableRow::text(std::string_view column) const {
  if (blank(column)) fail(column, "a value", "nothing", "Fill the field in.");
  return std::string(cell(column));
}

double TableRow::number(std::string_view column, int decimal_shift) const {
  const auto value = text::parse_number(cell(column), decimal_shift);
  if (!value || !std::isfinite(*value)) {
    fail(column, "a finite number", blank(column) ? "nothing" : cell(column),
         "Correct the number.");
  }
  return *value;
}

Eigen::Vector3d TableRow::place(std::array<std::string_view, 3> columns) const {
  constexpr int kMillimetres = -3;
  return {number(columns[0], kMillimetres), number(columns[1], kMillimetres),
          number(columns[2], kMillimetres)};
}

std::vector<std::string_view> TableRow::words(std::string_view column) const {
  std::vector<std::string_view> words;
  text::split_words(cell(column), words);
  return words;
}

void TableRow::fail(std::string_view column, std::string expected, std::string_view found,
                    std::string remedy) const {
  throw InputError(at_, {fmt::format("field '{}' is unusable", column), std::move(expected),
                         std::string(found), std::move(remedy)});
}

Table::Table(const EmbeddedTable& source, std::initializer_list<std::string_view> required,
             std::initializer_list<std::string_view> optional)
    : file_(source.file) {
  text::LineReader lines(source.text);
  while (const auto line = lines.next_filled()) {
    if (line->text.starts_with('#')) continue;
    if (columns_.empty()) {
      read_header(line->text, line->number, required, optional);
      continue;
    }
    std::vector<std::string_view> cells = split(line->text, ',');
    if (cells.size() != columns_.size()) {
      throw InputError(
          {file_, line->number},
          {"the row has another number of fields than the header", std::to_string(columns_.size()),
           std::to_string(cells.size()), "Add or remove commas."});
    }
    rows_.emplace_back(SourceLocation{file_, line->number}, &columns_, std::move(cells));
  }
  if (columns_.empty()) {
    throw InputError({file_, 0},
                     {"the table has no header", fmt::format("{}", fmt::join(required, ",")), "",
                      "Add the header."});
  }
}

void Table::read_header(std::string_view line, int number,
                        std::initializer_list<std::string_view> required,
                        std::initializer_list<std::string_view> optional) {
  const auto among = [](std::initializer_list<std::string_view> list, std::string_view name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  for (const std::string_view name : split(line, ',')) {
    const bool repeated = std::find(columns_.begin(), columns_.end(), name) != columns_.end();
    if (repeated || !(among(required, name) || among(optional, name))) {
      throw InputError({file_, number}, {repeated ? "a column stands twice" : "a column is unknown",
                                         fmt::format("columns {}", fmt::join(required, ",")),
                                         std::string(name), "Correct the header."});
    }
    columns_.emplace_back(name);
  }
  for (const std::string_view name : required) {
    if (std::find(columns_.begin(), columns_.end(), name) != columns_.end()) continue;
    throw InputError({file_, number}, {fmt::format("column '{}' is missing", name),
                                       fmt::format("columns {}", fmt::join(required, ",")),
                                       std::string(line), "Correct the header."});
  }
}

const EmbeddedTable& find_table(std::span<const EmbeddedTable> tables, std::string_view name) {
  const std::string file = fmt::format("model/whole_body/{}.csv", name);
  for (const EmbeddedTable& table : tables) {
    if (table.file == file) return table;
  }
  throw InputError({file, 0},
                   {"the table is missing", "a table of the body", "", "Add the file and build."});
}

std::vector<double> numbers_between_colons(const TableRow& row, std::string_view column,
                                           std::string_view word, std::size_t fewest,
                                           std::size_t most, int decimal_shift) {
  std::vector<double> numbers;
  bool good = true;
  for (const std::string_view part : split(word, ':')) {
    const auto value = text::parse_number(part, decimal_shift);
    good = good && value && std::isfinite(*value);
    numbers.push_back(value.value_or(0.0));
  }
  if (!good || numbers.size() < fewest || numbers.size() > most) {
    row.fail(column,
             fewest == most ? fmt::format("{} numbers joined by ':'", most)
                            : fmt::format("{} to {} numbers joined by ':'", fewest, most),
             word, "Correct the numbers.");
  }
  return numbers;
}

bool is_right(std::string_view name) {
  const std::size_t i = side_letter(name);
  return i != std::string_view::npos && name[i] == 'r';
}

std::string mirrored(std::string_view name) {
  std::string other(name);
  const std::size_t i = side_letter(name);
  if (i != std::string_view::npos) other[i] = name[i] == 'r' ? 'l' : 'r';
  return other;
}

}  // namespace sinew::anatomy
