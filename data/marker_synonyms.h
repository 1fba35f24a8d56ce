#pragma once

#include <string>
#include <vector>

namespace sinew {

/// A place on the body that marker sets name differently, and how sure it is that they mean the
/// same: `r:kne` for RKNE, R.Knee.Lat, RLFC, ...; `:sacr` for SACR and V.Sacral. Empty for names
/// that no table knows or that laboratories use for different places: clusters, wands, virtual
/// points. The tables, with their sources, are in data/marker_sets.cc.
std::string marker_site(const std::string& name);

/// The same of all names of one recording or model, whose company tells what some of them mean:
/// RLE is an elbow, but a knee beside the other names of the IOR set, and RKnee an epicondyle, but
/// the joint's centre beside key points such as Neck and MidHip.
std::vector<std::string> marker_sites(const std::vector<std::string>& names);

/// The site of a marker that a model has at the centre of a joint: `r:hjc` for RHJC and R_HJC;
/// empty for others.
std::string joint_centre_site(const std::string& name);

/// Whether a name is one of a marker on a wand or in a cluster, which sits anywhere on its segment:
/// RTHI, LTIB, R.Shank.Upper, LTHAP, r_thigh2, RUPA, LFRM, RBAK, ...
bool is_technical_marker(const std::string& name);

/// Those among the names.
std::vector<std::string> technical_markers(const std::vector<std::string>& names);

}  // namespace sinew
