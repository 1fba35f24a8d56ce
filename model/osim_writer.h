#pragma once

#include <string>
#include <vector>

#include "model/musculoskeletal_model.h"

namespace sinew {

/// The model as an OpenSim document of version 40000. read_osim() makes the same description of it
/// again, numbers to the last bit and orientations to 1e-15, and OpenSim 4 the same poses and
/// paths.
///
///  - Virtual links are bodies on a FreeJoint with a mass of 1 mg, which read_osim() takes for
///  none:
///    OpenSim refuses bodies without mass that carry no other.
///  - Tendons are PathSprings, ligaments keep their class or are Ligaments, muscles keep their
///  class
///    or are Millard2012EquilibriumMuscles.
///  - OpenSim refuses a PathSpring without stiffness. Where the description has none, it is such
///    that 3.3 % of stretch (Zajac 1989, Crit Rev Biomed Eng 17:359-411) carries the largest forces
///    of all muscles on its virtual links, or 1000 N where there are none.
///
/// Throws InputError for what such a document cannot say: names that OpenSim refuses, a muscle's
/// natural length that does not follow from fibre and tendon, a motion type of a coordinate that
/// does not follow from its joint. `model` must have passed validate(). O(size of the document).
std::string write_osim(const MusculoskeletalModel& model);

/// What the description knows of and the document of write_osim() lacks: elements that Sinew does
/// not treat, a warning a class, and surfaces that paths wrap over.
std::vector<Warning> losses_of_osim(const MusculoskeletalModel& model);

}  // namespace sinew
