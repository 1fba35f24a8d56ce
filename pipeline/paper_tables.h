#pragma once

#include <span>

namespace sinew {

/// A cell group of Tables I-IV of Ayusawa & Nakamura 2012 (Intel Core i7 X940, 2.13 GHz; LM from
/// the paper's reference [8]).
struct PaperRow {
  char letter;         // case A or B
  const char* method;  // our name for it
  bool decomposed;     // gradient by DGC
  int dof;
  double time_ms;
  int iterations;
  double final_cost;
};

/// All of them, in the paper's order.
std::span<const PaperRow> paper_rows();

/// The row of a run, or null where the paper has none.
const PaperRow* find_paper_row(char letter, const char* method, bool decomposed, int dof);

}  // namespace sinew
