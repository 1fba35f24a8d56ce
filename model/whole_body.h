#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "model/musculoskeletal_model.h"
#include "model/whole_body_table.h"

namespace sinew {

/// Whose body, and how finely it is strung.
struct WholeBodyOptions {
  enum class Level {
    kSimplified,  // bones and wires
    kDetailed,    // the same bones, more slips, and virtual links where muscles and tendons fork
  };
  enum class Sex { kMale, kFemale };

  Level level = Level::kDetailed;
  double height = 1.80;  // [m], from 1.20 to 2.30
  double mass = 75.0;    // [kg], from 20 to 250
  Sex sex = Sex::kMale;

  bool operator==(const WholeBodyOptions&) const = default;
  /// Throws std::invalid_argument naming field, value and bounds.
  void validate() const;
};

/// A whole human body: 155 degrees of freedom between bones, and muscles, tendons and ligaments as
/// wires. The detailed level adds virtual links of six degrees of freedom each. Every figure stands
/// with its source in a table under model/whole_body/.
///
///  - Axes: X forward, Y up, Z to the right. With all coordinates zero the body stands upright,
///  arms
///    hanging, palms to the thighs, and every bone's frame is parallel to the world's, its origin
///    in the joint that carries it.
///  - The left side is the right side's mirror image: the same value of a joint's coordinate on
///    either side gives mirrored poses. A virtual link's coordinates are those of a free joint, so
///    there turns about X and Y and shifts along Z change their sign.
///  - Height scales all lengths, mass all masses; sex chooses the masses, mass centres and radii of
///    gyration of the segments (de Leva 1996). Women keep the man's proportions of lengths.
///  - Natural lengths come from the neutral pose, where a path is L0 long. Tendons and ligaments:
///    L0 times the row's slackness (1 if blank). Muscles: optimal_fiber_length = fibre·L0,
///    tendon_slack_length = (1 − fibre)·L0, natural_length as PathElement says.
///
/// Throws std::invalid_argument if the options are out of bounds.
MusculoskeletalModel whole_body(const WholeBodyOptions& options = {});

/// As above, from other tables. Throws InputError naming table, line, field, what was expected and
/// what was found.
MusculoskeletalModel whole_body(const WholeBodyOptions& options,
                                std::span<const anatomy::EmbeddedTable> tables);

/// Options of the body that goes by a name in commands: "whole-body", simplified, and
/// "whole-body-detailed". Nothing for another name.
std::optional<WholeBodyOptions> find_whole_body(std::string_view name);

}  // namespace sinew
