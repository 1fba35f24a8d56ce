#include "pipeline/option_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "data/text.h"

namespace sinew {
namespace {

// `accepts` is asked with NaN for what is no number at all.
template <typename Accepts>
CLI::Validator number_check(std::string expected, Accepts accepts) {
  return CLI::Validator(
      [expected = std::move(expected), accepts](std::string& value) {
        const double number = text::parse_number(value).value_or(std::nan(""));
        return accepts(number) ? std::string() : fmt::format("{} is not {}", value, expected);
      },
      "");
}

bool integer(double x) { return std::isfinite(x) && x == std::floor(x); }

// More than any machine of a laboratory has; a thousand times that would only exhaust it.
constexpr int kMostThreads = 1024;

}  // namespace

CLI::Validator a_time() {
  return number_check("a time in seconds", [](double x) { return std::isfinite(x); });
}

CLI::Validator more_than_zero() {
  return number_check("a number above 0", [](double x) { return std::isfinite(x) && x > 0.0; });
}

CLI::Validator zero_or_more() {
  return number_check("a number, 0 or more", [](double x) { return std::isfinite(x) && x >= 0.0; });
}

CLI::Validator a_thread_count() {
  return number_check(
      fmt::format("a number of threads, 1 to {}, or 0 for all there are", kMostThreads),
      [](double x) { return integer(x) && x >= 0.0 && x <= kMostThreads; });
}

CLI::Validator a_stride() {
  return number_check("a whole number, 1 or more",
                      [](double x) { return integer(x) && x >= 1.0 && x <= 1e9; });
}

CLI::Validator a_start_count() {
  return number_check("a number of starts, 1 to 1000",
                      [](double x) { return integer(x) && x >= 1.0 && x <= 1000.0; });
}

CLI::Validator a_cutoff() {
  return number_check("a frequency in Hz above 0, or negative for no filter",
                      [](double x) { return std::isfinite(x) && x != 0.0; });
}

std::vector<std::string> split_names(std::string_view text) {
  std::vector<std::string> names;
  if (text == "none") return names;
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    if (comma > 0) names.emplace_back(text.substr(0, comma));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return names;
}

}  // namespace sinew
