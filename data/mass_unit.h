#pragma once

#include <optional>
#include <vector>

#include "data/verdict_reason.h"

namespace sinew {

/// What is known of a subject's mass besides what was entered.
struct MassEvidence {
  std::optional<double> carried;  // by the platforms [kg]
  std::optional<double> height;   // [m]
};

/// `mass-unit`: an entered mass that makes sense in pounds or newtons only. Held against what the
/// platforms carry, within 7 %: clothes, shoes and a walk that is not steady. Without platforms
/// against the height: a body mass index above 42 kg/m² (fewer than one adult in a hundred; NHANES
/// 2017-2018, NCHS Health E-Stats) that would be one of 14 to 30 in the other unit. Nothing where
/// neither is known or the mass is plausible. The remedy gives the mass in kilograms.
std::vector<VerdictReason> mass_unit_reasons(double mass, const MassEvidence& evidence);

}  // namespace sinew
