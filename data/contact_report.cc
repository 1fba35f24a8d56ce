#include <fmt/format.h>

#include <cmath>

#include "data/csv_file.h"
#include "data/foot_assignment.h"
#include "data/text.h"

namespace sinew {
namespace {

const char* name_of(PlateContact::State state) {
  if (state == PlateContact::State::kAssigned) return "assigned";
  return state == PlateContact::State::kUnusable ? "unusable" : "nobody";
}

}  // namespace

std::optional<AssignmentOverride> parse_override(const std::string& text) {
  const std::size_t colon = text.find(':'), at = text.find('@');
  if (colon == text.npos) return std::nullopt;
  AssignmentOverride result;
  const auto plate = text::parse_integer(text.substr(0, colon));
  if (!plate || *plate < 1 || *plate > 255) return std::nullopt;
  result.plate = static_cast<int>(*plate);
  result.foot = text.substr(colon + 1, at == text.npos ? at : at - colon - 1);
  if (result.foot.empty()) return std::nullopt;
  if (at == text.npos) return result;
  const std::string range = text.substr(at + 1);
  const std::size_t dash = range.find('-', 1);
  if (dash == range.npos) return std::nullopt;
  result.from = text::parse_number(range.substr(0, dash));
  result.to = text::parse_number(range.substr(dash + 1));
  if (!result.from || !result.to || !(*result.from < *result.to)) return std::nullopt;
  return result;
}

std::string contacts_csv(const FootAssignment& assignment,
                         const std::vector<ForcePlatformRecording>& plates) {
  std::string out = "platform,from_s,to_s,peak_n,foot,state,confidence,share,over_edge_m,reason\n";
  for (const PlateContact& c : assignment.contacts) {
    const std::string foot =
        c.foot < 0 ? "" : assignment.feet[static_cast<std::size_t>(c.foot)].name;
    out += fmt::format("{},{:.4f},{:.4f},{:.1f},{},{},{:.3f},{},{:.3f},{}\n",
                       plates[static_cast<std::size_t>(c.plate)].platform.number, c.from, c.to,
                       c.peak, foot, name_of(c.state), c.confidence,
                       std::isnan(c.share) ? "" : fmt::format("{:.3f}", c.share), c.outside,
                       csv_cell(c.reason));
  }
  return out;
}

std::string describe(const PlateContact& contact, const FootAssignment& assignment,
                     const std::vector<ForcePlatformRecording>& plates) {
  std::string text = fmt::format("platform {}, {:.2f} s to {:.2f} s: ",
                                 plates[static_cast<std::size_t>(contact.plate)].platform.number,
                                 contact.from, contact.to);
  if (contact.state == PlateContact::State::kAssigned) {
    text += fmt::format("{} foot ({:.0f} % sure)",
                        assignment.feet[static_cast<std::size_t>(contact.foot)].name,
                        100.0 * contact.confidence);
  } else {
    text += contact.state == PlateContact::State::kNobody ? "nobody" : "unusable";
  }
  return contact.reason.empty() ? text : text + ": " + contact.reason;
}

}  // namespace sinew
