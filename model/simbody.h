#pragma once

/// Simbody 3.7 under C++20; include this instead of <Simbody.h>. Two things need care.
///
/// Its index types compare with every integer type but not with each other. C++20 also tries those
/// comparisons with their arguments swapped, which makes `index == index` ambiguous in Simbody's
/// own headers. So each index type that is defined at namespace level gets the one comparison it
/// lacks.
///
/// The layout of its State depends on NDEBUG. Debian builds the library without NDEBUG, so its
/// headers are read without it in every build of ours; else a release build would crash.
#pragma push_macro("NDEBUG")
#undef NDEBUG

#include <SimTKcommon/internal/common.h>

#undef SimTK_DEFINE_UNIQUE_INDEX_TYPE
#define SimTK_DEFINE_UNIQUE_INDEX_TYPE(NAME) SimTK_DEFINE_AND_EXPORT_UNIQUE_INDEX_TYPE(, NAME)

#undef SimTK_DEFINE_AND_EXPORT_UNIQUE_INDEX_TYPE
#define SimTK_DEFINE_AND_EXPORT_UNIQUE_INDEX_TYPE(EXPORT, NAME)                          \
  SimTK_DEFINE_AND_EXPORT_UNIQUE_LOCAL_INDEX_TYPE(EXPORT, , ,                            \
                                                  NAME) static const NAME Invalid##NAME; \
  inline bool operator==(const NAME& a, const NAME& b) {                                 \
    return static_cast<int>(a) == static_cast<int>(b);                                   \
  }

#include <Simbody.h>

#pragma pop_macro("NDEBUG")
