#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace sinew {

/// Where in an input something stands. `line` counts from 1; 0 means the file as a whole.
struct SourceLocation {
  std::string file;
  int line = 0;

  bool operator==(const SourceLocation&) const = default;
};

/// `file:line`, or `file` where no line applies.
std::string to_string(const SourceLocation& at);

/// Thrown for every input that cannot be used. what() reads
/// `file:line: <problem>; expected <expected>, found <found>. <remedy>`, empty parts left out.
class InputError : public std::runtime_error {
 public:
  struct Parts {
    std::string problem;   // what is wrong, naming the field, column or element
    std::string expected;  // what would have been right
    std::string found;     // what stands there, shortened to 80 characters
    std::string remedy;    // what the user can do, a full sentence
  };

  InputError(SourceLocation at, Parts parts);

  const SourceLocation& where() const { return where_; }
  const Parts& parts() const { return parts_; }

 private:
  SourceLocation where_;
  Parts parts_;
};

/// Something in an input that was read all the same, and how it was understood.
struct Warning {
  SourceLocation at;
  std::string text;

  bool operator==(const Warning&) const = default;
};

std::string to_string(const Warning& warning);

}  // namespace sinew
