#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

using Json = nlohmann::ordered_json;

Json rows_of(const TemporaryFolder& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"bench", "walk", "--json", "rows.json"});
  const Outcome outcome = run_sinew(folder.path(), arguments);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return Json::parse(content_of(folder.path() / "rows.json"))["rows"];
}

TEST(BenchWalk, WritesARowForEveryMethodAndGradient) {
  const TemporaryFolder folder;
  const Json rows = rows_of(folder, {"--budget", "0.05"});
  std::map<std::string, std::set<std::string>> gradients;
  for (const Json& row : rows) {
    std::vector<std::string> fields;
    for (const auto& [field, value] : row.items()) fields.push_back(field);
    EXPECT_EQ(fields, (std::vector<std::string>{"model", "dof", "wires", "frames", "warm_start",
                                                "method", "gradient", "ms_per_frame", "iterations",
                                                "final_cost", "termination"}));
    const bool detailed = row["model"] == "detailed";
    EXPECT_EQ(row["dof"], detailed ? 587 : 155);
    EXPECT_EQ(row["wires"], detailed ? 1206 : 354);
    EXPECT_GE(row["frames"], 1);
    EXPECT_LE(row["frames"], row["warm_start"] ? 220 : 10);
    EXPECT_GT(row["ms_per_frame"], 0.0);
    gradients[row["method"]].insert(row["gradient"]);
  }
  EXPECT_EQ(rows.size(), 4 * (2 * 6 + 3));  // two levels, two starts
  EXPECT_EQ(gradients["bfgs"], (std::set<std::string>{"dgc", "jacobian"}));
  EXPECT_EQ(gradients["articulated"], std::set<std::string>{"dgc"});
}

// From the solution of the frame before, methods of first and of second order and both gradients
// find the same minimum, to the six digits after the point of the paper.
TEST(BenchWalk, MethodsAgreeOnTheCost) {
  const TemporaryFolder folder;
  const Json rows = rows_of(folder, {"--levels", "simplified", "--noise", "0", "--soft-tissue", "0",
                                     "--methods", "bfgs,gauss-newton,articulated"});
  std::vector<double> costs;
  for (const Json& row : rows) {
    if (!row["warm_start"].get<bool>()) continue;
    EXPECT_EQ(row["frames"], 220) << row;
    EXPECT_NE(row["termination"], "max-iterations") << row;
    costs.push_back(row["final_cost"]);
  }
  ASSERT_EQ(costs.size(), 5u);
  for (const double cost : costs) EXPECT_NEAR(cost, costs[0], 5e-7);
}

// Tensions that know which wires will be taut, their correction and the start from two frames leave
// little to do.
TEST(BenchWalk, TheDetailedBodyTakesFewIterations) {
  const TemporaryFolder folder;
  const Json rows = rows_of(folder, {"--levels", "detailed", "--noise", "0", "--soft-tissue", "0",
                                     "--methods", "articulated"});
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_TRUE(rows[1]["warm_start"].get<bool>());
  EXPECT_EQ(rows[1]["frames"], 220);
  EXPECT_EQ(rows[1]["termination"], "gradient");
  EXPECT_LT(rows[1]["iterations"], 4.0);
}

TEST(BenchWalk, StopsOnInterruptWithoutAFile) {
  const TemporaryFolder folder;
  const Outcome outcome = run_sinew(
      folder.path(), {"bench", "walk", "--methods", "steepest-descent", "--json", "r.json"},
      Interruption{3.0, ""});
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err;
  EXPECT_LT(outcome.seconds, 5.0);
  EXPECT_NE(outcome.err.find("stopped; no results were written"), std::string::npos);
  EXPECT_TRUE(tree_of(folder.path()).empty());
}

TEST(BenchWalk, RefusesNamesThatItDoesNotKnow) {
  const TemporaryFolder folder;
  const Outcome method = run_sinew(folder.path(), {"bench", "walk", "--methods", "downhill"});
  EXPECT_EQ(method.exit_code, 2);
  EXPECT_NE(method.err.find("there is no method 'downhill'; expected one of steepest-descent"),
            std::string::npos)
      << method.err;
  EXPECT_EQ(run_sinew(folder.path(), {"bench", "walk", "--levels", "complex"}).exit_code, 2);
  EXPECT_EQ(run_sinew(folder.path(), {"bench", "walk", "--budget", "0"}).exit_code, 2);
}

}  // namespace
}  // namespace sinew
