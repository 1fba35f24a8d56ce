#include "data/text.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace sinew::text {
namespace {

std::vector<std::string> lines_of(std::string_view content) {
  LineReader reader(content);
  std::vector<std::string> lines;
  while (const std::optional<Line> line = reader.next()) {
    EXPECT_EQ(line->number, static_cast<int>(lines.size()) + 1);
    lines.emplace_back(line->text);
  }
  return lines;
}

using Strings = std::vector<std::string>;

TEST(LineReader, EndsLinesAtEveryLineEnding) {
  EXPECT_EQ(lines_of("a\nb\r\nc\rd"), (Strings{"a", "b", "c", "d"}));
  EXPECT_EQ(lines_of("a\n\n\r\r\n"), (Strings{"a", "", "", ""}));
  EXPECT_EQ(lines_of(""), Strings{});
  EXPECT_EQ(lines_of("\xEF\xBB\xBFtime"), Strings{"time"});
}

TEST(LineReader, KnowsWhetherTheLastLineIsTerminated) {
  LineReader reader("a\nb");
  EXPECT_TRUE(reader.next()->terminated);
  EXPECT_FALSE(reader.next()->terminated);
  EXPECT_FALSE(reader.next().has_value());
}

TEST(LineReader, SkipsBlankLinesOnRequestAndKeepsCounting) {
  LineReader reader("\n \t \nx\n\n");
  EXPECT_EQ(reader.next_filled()->number, 3);
  EXPECT_FALSE(reader.next_filled().has_value());
}

TEST(Split, KeepsBlankCellsBetweenTabsAndDropsBlanksBetweenWords) {
  std::vector<std::string_view> cells;
  split_tabs("a b\t\t c \t", cells);
  EXPECT_EQ(cells, (std::vector<std::string_view>{"a b", "", "c", ""}));
  split_words("  a b\t\t c ", cells);
  EXPECT_EQ(cells, (std::vector<std::string_view>{"a", "b", "c"}));
  split_words(" \t ", cells);
  EXPECT_TRUE(cells.empty());
}

TEST(ParseNumber, ReadsWhatOtherProgramsWrite) {
  EXPECT_EQ(parse_number("12"), 12.0);
  EXPECT_EQ(parse_number("+1.5"), 1.5);
  EXPECT_EQ(parse_number("-2.73E-01"), -0.273);
  EXPECT_EQ(parse_number("1.0D+3"), 1000.0);
  EXPECT_EQ(parse_number("1.0d-3"), 0.001);
  EXPECT_EQ(parse_number("1e+005"), 1e5);
  EXPECT_EQ(parse_number("1."), 1.0);
  EXPECT_EQ(parse_number(".5"), 0.5);
  EXPECT_EQ(parse_number("1e-400"), 0.0);
  EXPECT_EQ(parse_number("INF"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("-infinity"), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(parse_number("-1.#INF"), -std::numeric_limits<double>::infinity());
  for (const char* word : {"NaN", "nan", "NAN", "-nan(ind)", "1.#QNAN", "-1.#IND", "+nan"}) {
    ASSERT_TRUE(parse_number(word).has_value()) << word;
    EXPECT_TRUE(std::isnan(*parse_number(word))) << word;
  }
}

TEST(ParseNumber, RefusesWhatIsNoNumber) {
  for (const char* word :
       {"",    " ",     "-",  "+", "1,5",   "1 2", "0x10", "1e", "1e+", "1e+-3", "--1",
        "+-1", "1.2.3", "e5", ".", "1e400", "n",   "not",  "in", "#",   "1d",    "12abc"}) {
    EXPECT_FALSE(parse_number(word).has_value()) << word;
    EXPECT_FALSE(parse_number(word, -3).has_value()) << word;
  }
}

TEST(ParseNumber, ShiftsTheDecimalPointWithOneRounding) {
  EXPECT_EQ(parse_number("617.247620", -3), 0.617247620);
  EXPECT_EQ(parse_number("-2.73E+02", -3), -0.273);
  EXPECT_EQ(parse_number("12.5", -2), 0.125);
  EXPECT_EQ(parse_number("0", -3), 0.0);
  EXPECT_EQ(parse_number("1e2147483647", -3), std::nullopt);
  EXPECT_EQ(parse_number("1e-99999999999", -3), 0.0);
}

TEST(ParseInteger, TakesWholeNumbersOnly) {
  EXPECT_EQ(parse_integer("151"), 151);
  EXPECT_EQ(parse_integer("+12.0"), 12);
  EXPECT_EQ(parse_integer("-3"), -3);
  for (const char* word : {"", "1.5", "nan", "inf", "1e300", "abc"}) {
    EXPECT_FALSE(parse_integer(word).has_value()) << word;
  }
}

TEST(FormatNumber, WritesTheShortestText) {
  EXPECT_EQ(format_number(0.1), "0.1");
  EXPECT_EQ(format_number(-1234.5), "-1234.5");
  EXPECT_EQ(format_number(1e15), "1000000000000000");
  EXPECT_EQ(format_number(-2e-7), "-2e-07");
  EXPECT_EQ(format_number(1e300), "1e+300");
  EXPECT_EQ(format_number(0.0), "0");
  EXPECT_EQ(format_number(-0.0), "-0");
  EXPECT_EQ(format_number(std::nan("")), "NaN");
  EXPECT_EQ(format_number(-std::numeric_limits<double>::infinity()), "-Inf");
  EXPECT_EQ(format_number(0.61724762, 3), "617.24762");
}

TEST(FormatNumber, RoundTripsEveryBitPattern) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200'000; ++i) {
    const std::uint64_t bits = random();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    if (!std::isfinite(value)) continue;
    ASSERT_EQ(parse_number(format_number(value)), value);
    if (std::abs(value) < 1e300) {
      ASSERT_EQ(parse_number(format_number(value, 3), -3), value);
    }
  }
}

}  // namespace
}  // namespace sinew::text
