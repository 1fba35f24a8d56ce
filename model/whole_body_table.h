#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "data/input_error.h"

/// The tables that the whole body is made from: UTF-8 text, fields between commas, `#` lines are
/// comments, the first other line is the header. Fields hold no commas and no quotes. Lengths are
/// in millimetres.
namespace sinew::anatomy {

/// A table as it stands in the program: its path in the project and its text.
struct EmbeddedTable {
  std::string_view file;
  std::string_view text;
};

/// Every table under model/whole_body/, embedded when the program was built.
std::span<const EmbeddedTable> whole_body_tables();

/// One row of a table. Every accessor names file, line, column, what was expected and what was
/// found in the InputError that it throws. The row must not outlive the table's text.
class TableRow {
 public:
  TableRow(SourceLocation at, const std::vector<std::string>* columns,
           std::vector<std::string_view> cells)
      : at_(std::move(at)), columns_(columns), cells_(std::move(cells)) {}

  const SourceLocation& at() const { return at_; }
  /// The field, empty if blank or if the table has no such column.
  std::string_view cell(std::string_view column) const;
  bool blank(std::string_view column) const { return cell(column).empty(); }
  /// The field, which must not be blank.
  std::string text(std::string_view column) const;
  /// The field as a finite number, times 10^decimal_shift.
  double number(std::string_view column, int decimal_shift = 0) const;
  /// Columns x, y, z [mm], or others in their place [m].
  Eigen::Vector3d place(std::array<std::string_view, 3> columns = {"x", "y", "z"}) const;
  /// The field's parts between blanks.
  std::vector<std::string_view> words(std::string_view column) const;

  [[noreturn]] void fail(std::string_view column, std::string expected, std::string_view found,
                         std::string remedy) const;

 private:
  SourceLocation at_;
  const std::vector<std::string>* columns_;
  std::vector<std::string_view> cells_;
};

class Table {
 public:
  /// Columns may stand in any order; those in `optional` may be missing. Throws InputError if one
  /// of `required` is missing, a column is unknown or there twice, or a row has another number of
  /// fields than the header.
  Table(const EmbeddedTable& source, std::initializer_list<std::string_view> required,
        std::initializer_list<std::string_view> optional = {});
  Table(Table&&) = delete;  // rows point to the columns

  const std::vector<TableRow>& rows() const { return rows_; }

 private:
  void read_header(std::string_view line, int number,
                   std::initializer_list<std::string_view> required,
                   std::initializer_list<std::string_view> optional);

  std::string file_;
  std::vector<std::string> columns_;
  std::vector<TableRow> rows_;
};

/// The table of that name (`joints` for model/whole_body/joints.csv). Throws InputError if it is
/// not among `tables`.
const EmbeddedTable& find_table(std::span<const EmbeddedTable> tables, std::string_view name);

/// `a:b:c` as numbers. Throws InputError naming `row` and `column` unless there are at least
/// `fewest` and at most `most`.
std::vector<double> numbers_between_colons(const TableRow& row, std::string_view column,
                                           std::string_view word, std::size_t fewest,
                                           std::size_t most, int decimal_shift = 0);

/// True of names of the right side: `_r` at the end or before another `_`.
bool is_right(std::string_view name);
/// The other side's name; names of the midline stay.
std::string mirrored(std::string_view name);
/// The place mirrored in the plane z = 0.
inline Eigen::Vector3d mirrored(const Eigen::Vector3d& p) { return {p.x(), p.y(), -p.z()}; }

}  // namespace sinew::anatomy
