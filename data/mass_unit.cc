#include "data/mass_unit.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace sinew {
namespace {

struct Unit {
  const char* name;
  double per_kilogram;
};
constexpr Unit kUnits[] = {{"pounds", 2.20462262}, {"newtons", 9.80665}};

constexpr double kTolerance = 0.07;
constexpr double kLargestIndex = 42.0, kLeanIndex = 14.0, kUsualIndex = 30.0;  // [kg/m²]

VerdictReason make(double mass, const Unit& unit, double expected, bool certain,
                   const std::string& against) {
  VerdictReason reason;
  reason.weight = certain ? VerdictReason::Weight::kUnusable : VerdictReason::Weight::kRemark;
  reason.code = "mass-unit";
  reason.figure = mass;
  reason.limit = expected;
  reason.unit = "kg";
  reason.text =
      fmt::format("the mass of {:.1f} kg seems to be in {}: {}", mass, unit.name, against);
  reason.source = certain ? "Sinew" : "NHANES 2017-2018";
  reason.remedy = fmt::format("--mass {:.1f}", mass / unit.per_kilogram);
  return reason;
}

}  // namespace

std::vector<VerdictReason> mass_unit_reasons(double mass, const MassEvidence& evidence) {
  if (evidence.carried) {
    for (const Unit& unit : kUnits) {
      const double ratio = mass / *evidence.carried / unit.per_kilogram;
      if (std::abs(ratio - 1.0) > kTolerance) continue;
      return {make(mass, unit, *evidence.carried, true,
                   fmt::format("the platforms carry {:.1f} kg", *evidence.carried))};
    }
    return {};
  }
  if (!evidence.height) return {};
  const double index = mass / (*evidence.height * *evidence.height);
  if (index < kLargestIndex) return {};
  for (const Unit& unit : kUnits) {
    const double other = index / unit.per_kilogram;
    if (other < kLeanIndex || other > kUsualIndex) continue;
    return {make(
        mass, unit, kLargestIndex * *evidence.height * *evidence.height, false,
        fmt::format("at {:.2f} m that is a body mass index of {:.0f}", *evidence.height, index))};
  }
  return {};
}

}  // namespace sinew
