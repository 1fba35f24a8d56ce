#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "pipeline/verdict.h"

namespace sinew {

/// What the end of `sinew run` tells.
struct RunDigest {
  const nlohmann::ordered_json& summary;  // summary.json's content
  const VerdictEvidence& evidence;        // with kinematics and dynamics
  const Verdict& verdict;
  double cutoff;                 // of the coordinates [Hz], negative for none
  std::filesystem::path folder;  // of the results
};

/// At most kMostLines lines: how well markers and forces are met, what is normal, the verdict, and
/// where the results are.
std::string run_digest(const RunDigest& digest);

}  // namespace sinew
