#pragma once

#include <string>
#include <vector>

#include "data/finding.h"
#include "data/trc_file.h"
#include "data/verdict_reason.h"

/// What findings about a laboratory's recordings mean for a run that goes on with them.
namespace sinew {

/// The options of `sinew run` that mend a finding about its trial, `--swap A,B@0.2-0.4`, or the
/// command that mends its static trial, of which the run takes a unit only; its advice where none
/// does.
std::string run_remedy(const Finding& finding, const std::string& static_trial);

/// Code `exchanged-markers`: markers that certainly bear each other's names (confidence from 0.95
/// on, from 0.8 on where both jump), which the solved pose hides. Not usable, however short of
/// the record from `begin` to `end` [s] it is: sizes are fitted to these samples, too. Codes
/// `forces-clock` and `forces-place`, remarks: forces that likely (from 0.6 on) come earlier or
/// later than the feet rest, or beside them. Other findings give none. O(findings).
std::vector<VerdictReason> finding_reasons(const std::vector<Finding>& findings, double begin,
                                           double end, const std::string& static_trial);

/// The same of a file of markers, whose own names tell what is up in it. The remedy is a command of
/// `sinew convert`. O(frames · markers + frames · pairs).
std::vector<VerdictReason> exchange_reasons(const MarkerFile& file);

}  // namespace sinew
