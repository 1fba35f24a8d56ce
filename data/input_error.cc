#include "data/input_error.h"

#include <fmt/format.h>

#include <utility>

namespace sinew {
namespace {

// Long enough to recognise a value in its file, short enough for one line of a terminal.
constexpr std::size_t kMaxFoundLength = 80;

std::string printable(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (result.size() >= kMaxFoundLength) return result + "...";
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
    result += control ? fmt::format("\\x{:02x}", static_cast<unsigned char>(c)) : std::string(1, c);
  }
  return result;
}

std::string message(const SourceLocation& at, const InputError::Parts& parts) {
  std::string text = to_string(at) + ": " + parts.problem;
  if (!parts.expected.empty()) text += "; expected " + parts.expected;
  if (!parts.found.empty()) {
    text += (parts.expected.empty() ? "; found " : ", found ") + printable(parts.found);
  }
  if (!parts.remedy.empty()) text += ". " + parts.remedy;
  return text;
}

}  // namespace

std::string to_string(const SourceLocation& at) {
  return at.line > 0 ? fmt::format("{}:{}", at.file, at.line) : at.file;
}

InputError::InputError(SourceLocation at, Parts parts)
    : std::runtime_error(message(at, parts)), where_(std::move(at)), parts_(std::move(parts)) {}

std::string to_string(const Warning& warning) {
  return to_string(warning.at) + ": " + warning.text;
}

}  // namespace sinew
