#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "data/finding.h"

namespace sinew {

/// How many findings are errors, warnings, notes.
struct FindingCounts {
  int errors = 0, warnings = 0, notes = 0;
};
FindingCounts count(const std::vector<Finding>& findings);

/// What a person reads: a block for each finding of one file.
std::string findings_text(const std::vector<Finding>& findings, const std::string& path);

/// The command that mends a finding, with the file it is about and a name for what it writes.
std::string remedy_command(const Finding& finding);

/// One object a finding.
nlohmann::ordered_json findings_json(const std::vector<Finding>& findings);

}  // namespace sinew
