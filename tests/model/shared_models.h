#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

/// The published models that tests run on where the folder is there; see its INDEX.md.
namespace sinew {

inline const std::filesystem::path kSharedData = "../shared/data";

/// Every .osim file below the folder, in the order of their names; empty where it is missing.
inline std::vector<std::filesystem::path> shared_models() {
  std::vector<std::filesystem::path> models;
  if (!std::filesystem::exists(kSharedData)) return models;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kSharedData)) {
    if (entry.path().extension() == ".osim") models.push_back(entry.path());
  }
  std::sort(models.begin(), models.end());
  return models;
}

/// The one published model without bodies, which is no model to Sinew.
inline bool has_no_bodies(const std::filesystem::path& model) {
  return model.filename() == "testWrapObject_updateFromXMLNode30515.osim";
}

}  // namespace sinew

#define SINEW_SKIP_WITHOUT_SHARED_DATA()                                           \
  if (!std::filesystem::exists(sinew::kSharedData)) {                              \
    GTEST_SKIP() << sinew::kSharedData << " is missing: no published models here"; \
  }
