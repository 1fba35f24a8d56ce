#pragma once

#include <string>
#include <vector>

namespace sinew {

/// A place on the body that marker sets name differently, and how sure it is that they mean the
/// same: `r:kne` for RKNE, R.Knee.Lat, RLFC, ...; `:sacr` for SACR and V.Sacral. Empty for names
/// that no table knows or that laboratories use for different places: clusters, wands, virtual
/// points.
///
/// From the descriptions of the sets, names only: Plug-in Gait (Vicon's manual; Davis et al. 1991,
/// Hum Mov Sci 10:575-587), Helen Hayes (Kadaba, Ramakrishnan, Wootten 1990, J Orthop Res
/// 8:383-392) as Motion Analysis' systems abbreviate it, Cleveland Clinic as OpenSim's example
/// subjects name it (Top.Head ... L.Toe.Tip), the calibration points of Cappozzo et al. (1995, Clin
/// Biomech 10:171-178), and the set of Rajagopal et al. (2016, IEEE TBME 63:2068-2079).
std::string marker_site(const std::string& name);

/// Whether a name is one of a marker on a wand or in a cluster, which sits anywhere on its segment:
/// RTHI, LTIB, R.Shank.Upper, LTHAP, r_thigh2, RUPA, LFRM, RBAK, ...
bool is_technical_marker(const std::string& name);

/// Those among the names.
std::vector<std::string> technical_markers(const std::vector<std::string>& names);

}  // namespace sinew
