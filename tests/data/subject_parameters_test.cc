#include "data/subject_parameters.h"

#include <gtest/gtest.h>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

C3dFile with(float mass, float height) {
  C3dFile file;
  set_parameter(file.groups, "PROCESSING", C3dParameter::of_reals("Bodymass", {1}, {mass}));
  set_parameter(file.groups, "PROCESSING", C3dParameter::of_reals("Height", {1}, {height}));
  return file;
}

TEST(SubjectParameters, AreThoseThatWereEntered) {
  EXPECT_EQ(subject_parameters(with(77.625F, 1700.0F)).mass, 77.625);
  EXPECT_NEAR(*subject_parameters(with(70.0F, 1700.0F)).height, 1.7, 1e-12);
  EXPECT_NEAR(*subject_parameters(with(70.0F, 1.75F)).height, 1.75, 1e-7);
  EXPECT_FALSE(subject_parameters(C3dFile()).mass);
  EXPECT_FALSE(subject_parameters(C3dFile()).height);
}

TEST(SubjectParameters, OfNobodyAreLeftOut) {
  EXPECT_FALSE(subject_parameters(with(0.0F, 0.0F)).mass);
  EXPECT_FALSE(subject_parameters(with(0.0F, 0.0F)).height);
  EXPECT_FALSE(subject_parameters(with(70000.0F, 17.0F)).mass);
  EXPECT_FALSE(subject_parameters(with(70000.0F, 17.0F)).height);
  C3dFile two = with(70.0F, 1700.0F);
  set_parameter(two.groups, "SUBJECTS", C3dParameter::of_integers("USED", {}, {2}));
  EXPECT_FALSE(subject_parameters(two).mass);
}

TEST(SubjectParameters, OfARecording) {
  const std::filesystem::path file =
      "../shared/data/c3d.org/sample_00/Vicon Motion Systems/pyCGM2 lower limb CGM24 "
      "Walking01.c3d";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << "no ../shared/data";
  const SubjectParameters subject = subject_parameters(read_c3d(file));
  EXPECT_EQ(subject.mass, 77.625);  // as ezc3d reads it
  EXPECT_EQ(subject.height, 1.7);
}

}  // namespace
}  // namespace sinew
