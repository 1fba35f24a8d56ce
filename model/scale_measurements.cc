#include "model/scale_measurements.h"

#include <fmt/format.h>

#include <cmath>

#include "model/kinematic_tree.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

class Measurer {
 public:
  Measurer(const MusculoskeletalModel& model, const ModelScalerSetup& scaler,
           const MarkerFile* recording)
      : model_(model),
        scaler_(scaler),
        recording_(recording),
        tree_(compile_tree(model)),
        workspace_(tree_),
        result_{ScaleFactors(model), {}, {}} {
    update_poses(tree_, workspace_);
    if (recording != nullptr) {
      std::tie(first_, last_) = frames_around(recording->markers, scaler.from, scaler.to);
    }
  }

  MeasuredFactors run() {
    for (const ModelScalerSetup::Step step : scaler_.order) {
      if (step == ModelScalerSetup::Step::kManual) {
        for (const ManualScale& scale : scaler_.manual.scales) apply(scale);
        continue;
      }
      for (const ScaleMeasurement& measurement : scaler_.measurements) {
        if (measurement.apply) apply(measurement);
      }
    }
    return std::move(result_);
  }

 private:
  void warn(const std::string& file, int line, std::string text) {
    result_.warnings.push_back({{file, line}, std::move(text)});
  }

  // Factors of a body; null, with a warning, where there is none.
  Vector3d* factors_of(const std::string& body, const std::string& file, int line) {
    const int b = model_.find_body(body);
    if (b > 0) return &result_.factors.of_body[static_cast<std::size_t>(b)];
    warn(
        file, line,
        b == 0 ? "ground is not scaled" : fmt::format("the model has no body '{}' to scale", body));
    return nullptr;
  }

  void apply(const ManualScale& scale) {
    if (!scale.apply) return;
    if (Vector3d* f = factors_of(scale.body, scaler_.manual.path, scale.line)) *f = scale.factors;
  }

  void apply(const ScaleMeasurement& measurement) {
    if (recording_ == nullptr) {
      throw InputError({scaler_.measurement_path, measurement.line},
                       {fmt::format("measurement '{}' needs a recording", measurement.name),
                        "<marker_file> with the markers of a static trial", "",
                        "Name one, or give --static FILE."});
    }
    MeasuredScale measured = measure(measurement);
    if (std::isfinite(measured.factor)) {
      for (const BodyScale& body : measurement.bodies) {
        Vector3d* f = factors_of(body.body, scaler_.measurement_path, body.line);
        for (std::size_t i = 0; f != nullptr && i < 3; ++i) {
          if (body.axes[i]) (*f)[static_cast<Eigen::Index>(i)] = measured.factor;
        }
      }
    }
    result_.measurements.push_back(std::move(measured));
  }

  MeasuredScale measure(const ScaleMeasurement& measurement) {
    MeasuredScale measured{measurement.name, kNaN, {}};
    double sum = 0.0;
    std::string missing;
    for (const ScaleMeasurement::Pair& pair : measurement.pairs) {
      const double distance = recorded(pair, missing);
      measured.pairs.push_back(
          {pair.first, pair.second, distance, in_model(pair, missing), frames_});
      const MeasuredPair& both = measured.pairs.back();
      sum += both.recorded / both.model;
    }
    if (measurement.pairs.empty()) missing = "it has no marker pairs";
    if (missing.empty()) {
      measured.factor = sum / static_cast<double>(measurement.pairs.size());
    } else {
      warn(scaler_.measurement_path, measurement.line,
           fmt::format("measurement '{}' is not used: {}", measurement.name, missing));
    }
    return measured;
  }

  double recorded(const ScaleMeasurement::Pair& pair, std::string& missing) {
    const MarkerTrajectories& markers = recording_->markers;
    const int a = markers.find_marker(pair.first), b = markers.find_marker(pair.second);
    frames_ = 0;
    if (a < 0 || b < 0) {
      missing =
          fmt::format("marker '{}' is not in the recording", a < 0 ? pair.first : pair.second);
      return kNaN;
    }
    double sum = 0.0;
    for (int frame = first_; frame <= last_; ++frame) {
      const double distance = (markers.position(frame, a) - markers.position(frame, b)).norm();
      if (std::isnan(distance)) continue;
      sum += distance;
      ++frames_;
    }
    if (frames_ == 0) {
      missing = fmt::format("markers '{}' and '{}' are never measured together in its time range",
                            pair.first, pair.second);
    }
    return sum / frames_;
  }

  Vector3d place(int marker) const {
    const Marker& m = model_.markers[static_cast<std::size_t>(marker)];
    return workspace_.X_WB[static_cast<std::size_t>(m.body)] * m.p_BM;
  }

  double in_model(const ScaleMeasurement::Pair& pair, std::string& missing) const {
    const int a = model_.find_marker(pair.first), b = model_.find_marker(pair.second);
    if (a < 0 || b < 0) {
      missing = fmt::format("marker '{}' is not in the model", a < 0 ? pair.first : pair.second);
      return kNaN;
    }
    const double distance = (place(a) - place(b)).norm();
    if (distance > 0.0) return distance;
    throw InputError({scaler_.measurement_path, pair.line},
                     {fmt::format("markers '{}' and '{}' are in one place in the model", pair.first,
                                  pair.second),
                      "two places", "", "Move one of them, or name other markers."});
  }

  const MusculoskeletalModel& model_;
  const ModelScalerSetup& scaler_;
  const MarkerFile* recording_;
  KinematicTree tree_;
  KinematicWorkspace workspace_;
  MeasuredFactors result_;
  int first_ = 0, last_ = -1;
  int frames_ = 0;  // of the pair measured last
};

}  // namespace

std::pair<int, int> frames_around(const MarkerTrajectories& markers, std::optional<double> from,
                                  std::optional<double> to) {
  constexpr double kRounding = 1e-10;  // [s]; files print times rounded
  const int last = markers.frame_count() - 1;
  int first = 0, end = last;
  if (from) {
    for (first = last; first > 0 && markers.time[first] > *from + kRounding;) --first;
  }
  if (to) {
    for (end = first; end < last && markers.time[end] < *to - kRounding;) ++end;
  }
  return {first, end};
}

MeasuredFactors measured_factors(const MusculoskeletalModel& model, const ModelScalerSetup& scaler,
                                 const MarkerFile* recording) {
  return Measurer(model, scaler, recording).run();
}

}  // namespace sinew
