#pragma once

#include <span>

namespace sinew {

/// A place on the body and what a set calls it, in lower case, without separators. On a limb the
/// side is left out too; `*` stands for it where it is in the middle: `waist*front`.
struct MarkerSetRow {
  const char* site;
  const char* names;
};

/// The names of a published marker set, from its description. Sets may share names as long as
/// these mean the same place; `only_together` are sets whose short names others use for other
/// places.
struct MarkerSet {
  const char* name;
  const char* source;
  std::span<const MarkerSetRow> sides, midline;
  // Names of which `least` different ones must be recorded for the set to hold; empty: its names
  // hold always.
  const char* only_together = "";
  int least = 0;
};

/// All sets. Sites have the names of the built-in whole body's markers, without side; `sjc`, `ejc`,
/// `wjc`, `hjc`, `kjc` and `ajc` are the centres of shoulder, elbow, wrist, hip, knee and ankle.
std::span<const MarkerSet> marker_sets();

/// What names of wands and clusters on a limb begin with, without side, separators and case.
std::span<const char* const> cluster_names();

}  // namespace sinew
