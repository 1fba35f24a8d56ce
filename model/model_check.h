#pragma once

#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// Something about a model that its author may not have meant.
struct ModelFinding {
  enum class Severity {
    kError,    // results with this are wrong or cannot be had
    kWarning,  // probably a mistake
    kNote,     // unusual; often right
  };

  Severity severity = Severity::kWarning;
  std::string kind;     // a word for the check, such as `asymmetry`
  std::string element;  // name of the body, joint, coordinate, path or marker
  std::string text;     // what is wrong, with figures
  SourceLocation source;
};

const char* to_string(ModelFinding::Severity severity);

struct ModelCheckOptions {
  double mirror_tolerance = 1e-3;         // between a place and its mirrored partner [m]
  double marker_mirror_tolerance = 0.02;  // the same of markers, which are placed by hand [m]
  double relative_tolerance = 0.01;       // between masses, inertias, forces of partners
  // From a point to the nearest joint, mass centre, marker or other path's point of its bone [m]:
  // on published whole-body models the farthest is 0.19 m away.
  double plausible_distance = 0.25;
  // Pulls on a virtual link within this angle of each other are one direction [rad].
  double least_spread = 0.09;

  /// Throws std::invalid_argument naming the field that is not above 0.
  void validate() const;
};

/// All findings, errors first, in the order of the model. Checked in the pose of all defaults:
///
/// | kind | what |
/// |---|---|
/// | reading | what the reader of the file warned of |
/// | asymmetry | left and right partners (`_r`/`_l`, `R`/`L`) that do not mirror each other |
/// | path | zero length, repeated points, points far from their bone |
/// | virtual link | without paths, pulled one way or towards one body only, with two ends only |
/// | coordinate | default outside its range |
/// | mass | bodies without mass that are no virtual links, inertias that no body has |
/// | muscle | crosses no joint that moves |
/// | natural length | shorter than the path in the default pose |
/// | marker | far from its bone; none of all on a body that moves |
///
/// `model` must have passed validate(). O(points²) of a bone.
std::vector<ModelFinding> check_model(const MusculoskeletalModel& model,
                                      const ModelCheckOptions& options = {});

/// The asymmetries alone. Partners mirror each other in their own frames by one axis for the whole
/// model: Z in OpenSim's models; the axis that leaves the smallest differences is taken.
std::vector<ModelFinding> check_symmetry(const MusculoskeletalModel& model,
                                         const ModelCheckOptions& options);

/// The name of the partner on the other side: `femur_r` → `femur_l`, `R.ASIS` → `L.ASIS`, `RKNE` →
/// `LKNE`, `soleus_medial_r_2` → `soleus_medial_l_2`; and the reverse. All names that could be
/// meant; empty for a name without a side.
std::vector<std::string> partner_names(const std::string& name);

}  // namespace sinew
