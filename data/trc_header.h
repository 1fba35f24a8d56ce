#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/marker_trajectories.h"
#include "data/text.h"

namespace sinew::trc {

inline constexpr std::size_t kLeadingCells = 2;  // Frame# and Time

/// What the first three lines of a TRC file say.
struct Header {
  double rate = 0.0;                  // [Hz]
  long long frames = 0, markers = 0;  // as promised
  int decimal_shift = 0;              // powers of ten from the file's unit to metres
  int line = 0;                       // of the values
};

/// How the rows of data are to be read.
struct Layout {
  std::size_t markers = 0;
  bool tabs = true;  // between cells, else blanks
  int decimal_shift = 0;
  text::Line first_row;
};

/// Reads the three lines. Throws InputError if they do not describe markers.
Header parse_header(const std::string& path, text::LineReader& lines);

/// Reads the names, the labels X1 Y1 Z1 ..., which some writers leave out, and the first row. Fills
/// the names of `file`, unique, and its warnings; `labels`, where given, gets them as they are.
/// Throws InputError if names and coordinates do not fit or no row follows.
Layout parse_columns(const Header& header, text::LineReader& lines, MarkerFile& file,
                     std::vector<std::string>* labels = nullptr);

}  // namespace sinew::trc
