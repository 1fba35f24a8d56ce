#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/verdict.h"

namespace sinew {

/// Lines at the end of a command's output: what fits a small window.
constexpr int kMostLines = 12;

/// `good`, `remarks`, `unusable`.
const char* to_string(Verdict::Level level);
/// `none`, `usable`, `partly`, `unusable`.
const char* to_string(JointVerdict::Use use);

/// verdict.json: {"verdict", "reasons": [{"code", "weight", "text", "figure", "limit", "unit",
/// "source", "remedy", "angles", "torques"}], "joints": {NAME: {"angles", "torques"}}}. Figures
/// that there are none of are null.
nlohmann::ordered_json verdict_json(const Verdict& verdict);

/// Residuals at the root and the frames that they are of, for summary.json: the figures that the
/// verdict rests on and that print_... shows.
nlohmann::ordered_json root_json(const DynamicsEvidence& dynamics);
/// The same in a line: `at the root, in 92 of 315 frames: force 71 N RMS (14 % of the largest
/// ground force, normal: at most 5 %), ...`. Empty for a model that the ground holds, and without
/// loads.
std::string root_text(const DynamicsEvidence& dynamics);

/// What to show at the end, in at most `lines` lines, 3 or more: the verdict, the weightiest
/// reasons, how many more there are, and joints that cannot be used.
std::string verdict_text(const Verdict& verdict, int lines);

/// The file of a verdict beside an output: `q.mot` → `q_verdict.json`.
std::filesystem::path verdict_path(const std::filesystem::path& output);

/// Writes the file, atomically. Bytes of names that are not UTF-8 are replaced.
void write_verdict(const std::filesystem::path& file, const Verdict& verdict);

/// kExitFailed for a result that cannot be used, unless it is accepted.
int exit_code(const Verdict& verdict, bool accepted);

/// What --accept says in --help.
extern const char* const kAcceptHelp;

}  // namespace sinew
