#include "data/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "data/input_error.h"
#include "data/input_file.h"
#include "data/numbers.h"

namespace sinew::text {
namespace {

constexpr std::string_view kWhiteSpace = " \t\r\n\v\f";
constexpr double kInfinity = std::numeric_limits<double>::infinity();

char lower_char(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// The words for what is no finite number; `unsigned_text` has no sign any more.
std::optional<double> parse_non_finite(std::string_view unsigned_text) {
  const std::string word = lower(unsigned_text);
  if (word == "nan" || word.starts_with("nan(")) return kNaN;
  if (word.starts_with("1.#qnan") || word.starts_with("1.#snan") || word.starts_with("1.#ind")) {
    return kNaN;
  }
  if (word == "inf" || word == "infinity" || word.starts_with("1.#inf")) return kInfinity;
  return std::nullopt;
}

// A mantissa and a power of ten: what stands before and after `e`, `E`, `d` or `D`.
struct Decimal {
  std::string_view mantissa;
  int exponent = 0;
};

std::optional<Decimal> split_exponent(std::string_view text) {
  const std::size_t mark = text.find_first_of("eEdD");
  if (mark == std::string_view::npos) return Decimal{text, 0};
  std::string_view digits = text.substr(mark + 1);
  const bool signed_plus = !digits.empty() && digits.front() == '+';
  if (signed_plus) digits.remove_prefix(1);
  if (signed_plus && !digits.empty() && digits.front() == '-') return std::nullopt;
  int exponent = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
  if (end != digits.data() + digits.size() || digits.empty()) return std::nullopt;
  // Far outside of what a double holds, where adding a shift cannot overflow an int either.
  if (error != std::errc() || std::abs(exponent) > 1'000'000) {
    exponent = digits.front() == '-' ? -1'000'000 : 1'000'000;
  }
  return Decimal{text.substr(0, mark), exponent};
}

std::optional<double> parse_whole(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size() || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc()) return value;
  // from_chars tells neither side of the range; a magnitude below one can only have underflowed.
  const std::optional<Decimal> decimal = split_exponent(text);
  const bool underflow = decimal && (decimal->exponent < 0 || decimal->mantissa.starts_with("0."));
  return underflow ? std::optional(0.0) : std::nullopt;
}

bool is_mantissa(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789.") == std::string_view::npos;
}

std::optional<double> parse_unsigned(std::string_view text, int decimal_shift) {
  if (!text.empty() && (text.find('#') != text.npos || lower_char(text.front()) == 'n' ||
                        lower_char(text.front()) == 'i')) {
    return parse_non_finite(text);
  }
  const std::optional<Decimal> decimal = split_exponent(text);
  if (!decimal || !is_mantissa(decimal->mantissa)) return std::nullopt;
  if (decimal_shift == 0 && text.find_first_of("dD") == text.npos && text.find("e+") == text.npos &&
      text.find("E+") == text.npos) {
    return parse_whole(text);
  }
  return parse_whole(fmt::format("{}e{}", decimal->mantissa, decimal->exponent + decimal_shift));
}

// Digits d₀d₁d₂… standing for ±d₀.d₁d₂… × 10^exponent, with the point set where people expect it.
std::string place_point(std::string_view digits, int exponent) {
  const int count = static_cast<int>(digits.size());
  // The limits of %.17g, beyond which zeros would only pad.
  if (exponent < -5 || exponent > 16) {
    std::string text(digits.substr(0, 1));
    if (count > 1) text.append(".").append(digits.substr(1));
    return text + fmt::format("e{:+03}", exponent);
  }
  if (exponent < 0) return "0." + std::string(-exponent - 1, '0') + std::string(digits);
  if (count <= exponent + 1) return std::string(digits) + std::string(exponent + 1 - count, '0');
  return fmt::format("{}.{}", digits.substr(0, exponent + 1), digits.substr(exponent + 1));
}

}  // namespace

LineReader::LineReader(std::string_view content) : rest_(content) {
  if (rest_.starts_with("\xEF\xBB\xBF")) rest_.remove_prefix(3);
}

std::optional<Line> LineReader::next() {
  if (rest_.empty()) return std::nullopt;
  // Saturates, because a file of 4 GiB may have more lines than an int counts.
  if (number_ < std::numeric_limits<int>::max()) ++number_;
  const std::size_t end = rest_.find_first_of("\r\n");
  if (end == std::string_view::npos) {
    const Line line{rest_, number_, false};
    rest_ = {};
    return line;
  }
  const Line line{rest_.substr(0, end), number_, true};
  const bool crlf = rest_.substr(end).starts_with("\r\n");
  rest_.remove_prefix(end + (crlf ? 2 : 1));
  return line;
}

std::optional<Line> LineReader::next_filled() {
  for (std::optional<Line> line = next(); line; line = next()) {
    if (line->text.find_first_not_of(kWhiteSpace) != std::string_view::npos) return line;
  }
  return std::nullopt;
}

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kWhiteSpace);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kWhiteSpace) - first + 1);
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), lower_char);
  return result;
}

bool equals_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower_char(x) == lower_char(y); });
}

void split_tabs(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t tab = line.find('\t'); tab != line.npos; tab = line.find('\t')) {
    cells.push_back(trim(line.substr(0, tab)));
    line.remove_prefix(tab + 1);
  }
  cells.push_back(trim(line));
}

void split_words(std::string_view line, std::vector<std::string_view>& words) {
  words.clear();
  std::size_t begin = line.find_first_not_of(kWhiteSpace);
  while (begin != line.npos) {
    const std::size_t end = std::min(line.find_first_of(kWhiteSpace, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kWhiteSpace, end);
  }
}

std::string read_text_file(const std::filesystem::path& path, const std::string& format) {
  std::string content = read_file(path);
  if (trim(content).empty()) {
    throw InputError({path.string(), 0}, {"is empty", format, "", "Was it written completely?"});
  }
  if (content.find('\0') != content.npos) {
    throw InputError({path.string(), 0}, {"is binary or UTF-16", format + " in plain text", "",
                                          "Is it the right file? Save it as UTF-8 text."});
  }
  return content;
}

std::string remedy_for_number(std::string_view cell) {
  return cell.find(',') == cell.npos ? "Correct the value."
                                     : "Write decimals with a point, not a comma.";
}

std::optional<double> parse_number(std::string_view text, int decimal_shift) {
  if (text.empty()) return std::nullopt;
  const bool negative = text.front() == '-';
  if (negative || text.front() == '+') text.remove_prefix(1);
  const std::optional<double> magnitude = parse_unsigned(text, decimal_shift);
  if (!magnitude) return std::nullopt;
  return negative ? -*magnitude : *magnitude;
}

std::optional<long long> parse_integer(std::string_view text) {
  const std::optional<double> value = parse_number(text);
  constexpr double kLargest = 9007199254740992.0;  // 2^53: every whole number up to it is a double
  if (!value || !(std::abs(*value) <= kLargest) || *value != std::floor(*value)) {
    return std::nullopt;
  }
  return static_cast<long long>(*value);
}

std::string format_number(double value, int decimal_shift) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value > 0.0 ? "Inf" : "-Inf";
  if (value == 0.0) return std::signbit(value) ? "-0" : "0";
  std::array<char, 32> buffer;  // -d.dddddddddddddddde-308 is 24 long
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                          std::abs(value), std::chars_format::scientific);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
  const Decimal decimal = split_exponent(text).value();
  std::string digits(decimal.mantissa);
  std::erase(digits, '.');
  return (value < 0.0 ? "-" : "") + place_point(digits, decimal.exponent + decimal_shift);
}

}  // namespace sinew::text
