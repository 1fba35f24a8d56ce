#include "pipeline/version.h"

#include <fmt/format.h>
#include <tbb/version.h>

#include <Eigen/Core>

#include "model/simbody.h"

namespace sinew {

std::string version() { return SINEW_VERSION; }

std::map<std::string, std::string> component_versions() {
  int major = 0, minor = 0, build = 0;
  SimTK_version_SimTKcommon(&major, &minor, &build);
  return {{"sinew", version()},
          {"compiler", __VERSION__},
          {"simbody", fmt::format("{}.{}.{}", major, minor, build)},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"tbb", TBB_VERSION_STRING}};
}

}  // namespace sinew
