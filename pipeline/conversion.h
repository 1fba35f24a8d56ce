#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/gait_events.h"
#include "data/time_table.h"
#include "pipeline/laboratory.h"
#include "pipeline/prepare_options.h"
#include "pipeline/recording.h"

namespace sinew {

/// Recordings from one format to another; what each step does is printed in a line. Throws
/// InputError for unusable files and std::invalid_argument naming the option that does not fit.
struct Conversion {
  std::string what;                // part of a C3D file; empty: what the target's format is for
  std::string events;              // `forces`, `kinematics`, `all`: those written into a C3D file
  std::optional<double> from, to;  // [s]
  bool integers = false;           // of C3D files that are written
  PrepareOptions prepare;
  std::vector<Warning> warnings;  // of all that was read

  /// One file into one; with gap filling also filled_path(output).
  void convert(const std::string& input, const std::filesystem::path& output);
  /// Several inputs into one C3D file: one recording of markers, and tables as analog channels.
  void merge(const std::vector<std::string>& inputs, const std::string& out);

  /// The list of filled samples, beside the output; empty where nothing is filled.
  std::filesystem::path filled_path(const std::filesystem::path& output) const;

  /// The table's rows between `from` and `to`.
  TimeTable cropped(const TimeTable& table, const std::string& path);

 private:
  std::string what_of(Format target) const;
  std::pair<int, int> frames(const Eigen::VectorXd& time, const std::string& path);
  void done(const std::filesystem::path& output, const char* what_is, Eigen::Index rows,
            double rate) const;
  void write_markers(const std::filesystem::path& output, const MarkerTrajectories& markers);
  void write_table(const std::filesystem::path& output, const TimeTable& table);

  void edit_part(Recording& recording) const;
  void write_events(const std::filesystem::path& output, const std::string& input,
                    std::vector<GaitEvent> found, const MarkerTrajectories& markers) const;

  void condition(Recording& recording, const std::filesystem::path& output);
  void fill_and_filter(MarkerTrajectories& markers, const std::string& path,
                       const std::filesystem::path& output);
  void condition_markers(Recording& recording, const std::filesystem::path& output);
  void condition_table(Recording& recording);

  // Of C3D files: conversion_c3d.cc.
  void from_c3d(const std::string& input, const std::filesystem::path& output);
  void stream_markers(const std::string& input, const std::filesystem::path& output);
  Turn turn_of_start(const std::string& input, const C3dLayout& layout);
  void convert_c3d(const std::string& input, const std::filesystem::path& output);
  void convert_forces(const C3dFile& file, std::vector<ForcePlatformRecording> plates,
                      const std::filesystem::path& output);
  TimeTable analog_table(const C3dFile& file);
  TimeTable computed_table(const C3dFile& file);
  void rewrite_c3d(const std::string& input, const std::filesystem::path& output);
  void filter_analog(C3dFile& file) const;
};

}  // namespace sinew
