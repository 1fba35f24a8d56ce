#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "data/text.h"

namespace sinew::storage {

/// A count that the header promises, and where.
struct Promise {
  std::string key;
  long long count = 0;
  int line = 0;
};

/// What a MOT or STO file says up to `endheader`.
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

/// The line of labels.
struct Columns {
  std::vector<std::string> labels;  // one a cell, `time` included
  std::size_t time = 0;
  int line = 0;
};

/// Reads up to `endheader`. Throws InputError if it is missing or a value says nothing.
Header parse_header(const std::string& path, text::LineReader& lines);

/// What each number of a cell adds to its column's label, as OpenSim flattens vectors: {""} for
/// plain numbers. Throws InputError for an unknown DataType.
std::vector<std::string> element_suffixes(const std::string& path, const Header& header);

/// Reads the line of labels. Throws InputError if it is missing or not exactly one is `time`.
Columns parse_columns(const std::string& path, const Header& header, text::LineReader& lines);

/// True if `name` as first line of a file would be read as a key of the header.
bool reads_as_key(const std::string& name);

/// True for keys whose meaning the fields of a TimeTable carry, or that follow from the data.
bool is_structural_key(std::string_view key);

}  // namespace sinew::storage
