#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What the readers of text tables share. Nothing here depends on the locale.
namespace sinew::text {

/// One line of a text, without its line ending.
struct Line {
  std::string_view text;
  int number = 0;           // from 1
  bool terminated = false;  // false for a last line that no line ending follows
};

/// Walks over the lines of a text; LF, CRLF and a lone CR each end one. A UTF-8 byte order mark is
/// skipped. The text must outlive the reader. O(bytes) in all.
class LineReader {
 public:
  explicit LineReader(std::string_view content);
  /// The next line, or nothing at the end.
  std::optional<Line> next();
  /// The next line that holds more than white space, or nothing at the end.
  std::optional<Line> next_filled();

 private:
  std::string_view rest_;
  int number_ = 0;
};

/// Without the blanks, tabs and other white space around it.
std::string_view trim(std::string_view text);
std::string lower(std::string_view text);
bool equals_ignoring_case(std::string_view a, std::string_view b);

/// Replaces `cells` by the trimmed cells between tabs; n tabs make n + 1 cells.
void split_tabs(std::string_view line, std::vector<std::string_view>& cells);
/// Replaces `words` by the words between white space.
void split_words(std::string_view line, std::vector<std::string_view>& words);

/// The content of a text file of some `format`, for messages: "a TRC file". Throws InputError as
/// read_file does, and if the file is empty or holds a NUL byte, as UTF-16 and binary formats do.
std::string read_text_file(const std::filesystem::path& path, const std::string& format);

/// What to do about a cell that is no number: the sentence that ends a message.
std::string remedy_for_number(std::string_view cell);

/// The number that `text` is, times 10^decimal_shift, rounded once: `617.2` mm read with a shift of
/// -3 is exactly the double nearest to 0.6172. Accepts a leading `+`, Fortran's `D` exponents, NaN,
/// Inf and Infinity in any case and Microsoft's `1.#QNAN`, `-1.#IND` and `1.#INF`. Nothing if it is
/// no number, has anything after it or overflows.
std::optional<double> parse_number(std::string_view text, int decimal_shift = 0);
/// A whole number, which may be written `12`, `+12`, `12.0` or `1.2e1`; nothing beyond ±2^53.
std::optional<long long> parse_integer(std::string_view text);

/// The shortest text that parse_number reads back as the same double when given the opposite shift:
/// format_number(x, 3) is x in thousandths. `NaN`, `Inf` and `-Inf` for what is not finite.
std::string format_number(double value, int decimal_shift = 0);

}  // namespace sinew::text
