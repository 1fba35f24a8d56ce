#include "pipeline/paper_tables.h"

#include <string_view>

namespace sinew {
namespace {

constexpr PaperRow kRows[] = {
    {'A', "levenberg-marquardt", false, 12, 26.0, 1870, 3.2e-10},
    {'A', "levenberg-marquardt", false, 120, 456, 2881, 1.6e-9},
    {'A', "levenberg-marquardt", false, 1200, 17247, 19982, 8.0e-9},
    {'A', "bfgs", false, 12, 0.6, 25, 1.7e-11},
    {'A', "bfgs", false, 120, 202, 132, 2.0e-9},
    {'A', "bfgs", false, 1200, 12259, 328, 1.2e-8},
    {'A', "bfgs", true, 12, 0.6, 25, 1.7e-11},
    {'A', "bfgs", true, 120, 207, 139, 2.0e-9},
    {'A', "bfgs", true, 1200, 12198, 321, 1.2e-8},
    {'A', "conjugate-gradient", false, 12, 0.9, 43, 2.3e-11},
    {'A', "conjugate-gradient", false, 120, 120, 1092, 1.0e-8},
    {'A', "conjugate-gradient", false, 1200, 2834, 2441, 3.1e-7},
    {'A', "conjugate-gradient", true, 12, 0.7, 42, 3.5e-10},
    {'A', "conjugate-gradient", true, 120, 56, 526, 9.9e-9},
    {'A', "conjugate-gradient", true, 1200, 3567, 2642, 6.5e-8},
    {'B', "levenberg-marquardt", false, 12, 36.0, 508, 2.5e-10},
    {'B', "levenberg-marquardt", false, 120, 3309, 1208, 6.2e-10},
    {'B', "levenberg-marquardt", false, 1200, 1379010, 3802, 1.8e-9},
    {'B', "bfgs", false, 12, 0.7, 25, 1.1e-13},
    {'B', "bfgs", false, 120, 246, 110, 3.5e-9},
    {'B', "bfgs", false, 1200, 58195, 292, 4.2e-9},
    {'B', "bfgs", true, 12, 0.6, 25, 1.1e-13},
    {'B', "bfgs", true, 120, 156, 110, 3.5e-9},
    {'B', "bfgs", true, 1200, 41223, 298, 3.5e-9},
    {'B', "conjugate-gradient", false, 12, 13.0, 640, 2.4e-9},
    {'B', "conjugate-gradient", false, 120, 1120, 2209, 5.8e-8},
    {'B', "conjugate-gradient", false, 1200, 937507, 22509, 3.9e-8},
    {'B', "conjugate-gradient", true, 12, 7.9, 640, 2.4e-9},
    {'B', "conjugate-gradient", true, 120, 248, 2278, 7.8e-8},
    {'B', "conjugate-gradient", true, 1200, 25628, 24484, 3.6e-8},
};

}  // namespace

std::span<const PaperRow> paper_rows() { return kRows; }

const PaperRow* find_paper_row(char letter, const char* method, bool decomposed, int dof) {
  for (const PaperRow& row : kRows) {
    if (row.letter == letter && std::string_view(row.method) == method &&
        row.decomposed == decomposed && row.dof == dof) {
      return &row;
    }
  }
  return nullptr;
}

}  // namespace sinew
