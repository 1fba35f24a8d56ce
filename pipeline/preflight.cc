#include "pipeline/preflight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "data/carried_mass.h"
#include "data/force_signal.h"
#include "data/gait_events.h"
#include "data/laboratory_axes.h"
#include "data/mass_unit.h"
#include "data/preflight_forces.h"
#include "data/preflight_gaps.h"
#include "data/preflight_markers.h"
#include "data/preflight_order.h"
#include "data/preflight_rate.h"
#include "data/preflight_sides.h"
#include "data/preflight_spikes.h"
#include "data/preflight_swaps.h"
#include "data/preflight_timing.h"
#include "data/preflight_units.h"
#include "data/static_trial.h"
#include "data/subject_parameters.h"
#include "model/marker_fit.h"
#include "pipeline/laboratory.h"

namespace sinew {
namespace {

using Severity = Finding::Severity;

void append(std::vector<Finding>& all, std::vector<Finding> more) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

// Looks at one recording.
class Check {
 public:
  // `partner`: the recording whose markers a table of forces is held against, or null.
  Check(const PreflightRecording& recording, const PreflightRecording* partner,
        const PreflightInputs& inputs)
      : recording_(recording), partner_(partner), inputs_(inputs) {}

  std::vector<Finding> run() {
    note_warnings();
    if (recording_.c3d) {
      platforms_ = compute_forces(*recording_.c3d, {.threshold = inputs_.threshold});
      note_platforms();
    }
    if (recording_.markers) append(findings_, find_timing_faults(markers()));
    if (has_markers(recording_)) {
      find_laboratory();
      check_markers();
    }
    check_forces();
    if (recording_.c3d) check_events();
    for (Finding& finding : findings_) {
      if (finding.file.empty()) finding.file = recording_.path;
    }
    std::stable_sort(findings_.begin(), findings_.end(),
                     [](const Finding& a, const Finding& b) { return a.severity < b.severity; });
    return std::move(findings_);
  }

 private:
  static bool has_markers(const PreflightRecording& recording) {
    return recording.markers && recording.markers->marker_count() > 0 &&
           recording.markers->frame_count() > 0;
  }
  const MarkerTrajectories& markers() const { return *recording_.markers; }

  Finding& add(Severity severity, const char* kind, std::string text, double confidence) {
    Finding finding;
    finding.severity = severity;
    finding.kind = kind;
    finding.text = std::move(text);
    finding.confidence = confidence;
    findings_.push_back(std::move(finding));
    return findings_.back();
  }

  void note_warnings() {
    for (const Warning& warning : recording_.warnings) {
      // What find_duplicate_markers says with its remedy.
      if (warning.text.find("POINT:LABELS repeats") != std::string::npos) continue;
      if (warning.text.find("appears again") != std::string::npos) continue;
      Finding& finding = add(Severity::kNote, "reading", warning.text, 1.0);
      if (warning.at.line > 0) finding.where = fmt::format("line {}", warning.at.line);
    }
  }

  void note_platforms() {
    for (const Warning& warning : platforms_.warnings) {
      add(Severity::kNote, "platform", warning.text, 1.0);
    }
    for (const ForcePlatformRecording& plate : platforms_.recordings) {
      if (plate.platform.usable()) continue;
      std::erase_if(findings_, [&](const Finding& f) {
        return f.kind == "platform" && f.text.ends_with(plate.platform.problem);
      });
      Finding& finding =
          add(Severity::kWarning, "platform", "it cannot be used: " + plate.platform.problem, 1.0);
      finding.where = fmt::format("platform {}", plate.platform.number);
      finding.advice = "its forces are left out; correct the group FORCE_PLATFORM where they count";
    }
  }

  // Turned only if nothing is known by names; what the user would be told by `sinew convert`.
  void find_laboratory() {
    std::optional<C3dScreen> screen;
    if (recording_.c3d) screen = recording_.c3d->screen;
    axes_ = find_axes(axis_evidence(markers(), screen, platforms_.recordings));
    if (!axes_.up.known()) {
      Finding& finding = add(Severity::kWarning, "axes", "nothing tells which axis points up", 0.5);
      finding.flags = {"--up", "y"};
      finding.advice = "or z, x, -x, -y, -z: whichever does";
      return;
    }
    const std::vector<std::string> flags = {"--up", axis_name(axes_.up.axis), "--forward",
                                            axis_name(axes_.forward.axis)};
    for (const std::string& sentence : axes_.contradictions) {
      add(Severity::kWarning, "axes", sentence, 0.7).flags = flags;
    }
    Finding& finding = add(Severity::kNote, "axes", describe_axes(axes_), axes_.up.confidence);
    // Models stand y up; tables of markers are taken as they are, C3D files are turned.
    if (axes_.up.axis.y() == 1.0 || recording_.c3d) return;
    finding.severity = Severity::kWarning;
    finding.text += "; models stand with y up";
    finding.flags = flags;
  }

  void check_markers() {
    const std::vector<Finding> unit = find_unit_faults(markers(), recording_.metres_per_unit);
    append(findings_, unit);
    append(findings_, find_missing_markers(markers()));
    append(findings_, find_duplicate_markers(markers(), recording_.labels));
    // Of a giant every marker is far from the others.
    if (unit.empty()) append(findings_, find_stray_markers(markers()));
    append(findings_, find_static_markers(markers()));
    append(findings_, find_swap_faults(markers(), axes_));
    if (unit.empty()) {
      append(findings_, find_spike_faults(markers(), find_marker_swaps(markers())));
    }
    append(findings_, find_side_faults(markers(), axes_));
    append(findings_, find_order_faults(markers(), axes_));
    append(findings_, find_gap_faults(markers()));
    if (!inputs_.model) return;
    append(findings_, find_unmatched_markers(markers(), *inputs_.model));
    std::vector<Finding> sizes = find_size_faults(markers(), *inputs_.model);
    for (Finding& finding : sizes) {
      if (finding.kind == "size") set_scaling(finding);
    }
    append(findings_, sizes);
  }

  // What scales the model to these markers; `sinew scale` reads TRC files.
  void set_scaling(Finding& finding) const {
    if (recording_.c3d) {
      finding.command = "run";
      finding.flags = {"--c3d", recording_.path, "--model", inputs_.model_path, "--scale", "walk"};
      finding.advice = "or --static with a trial in which the subject stands";
    } else {
      finding.command = "scale";
      finding.flags = {"--auto",        "--model", inputs_.model_path, "--markers",
                       recording_.path, "--out",   "scaled.osim"};
      finding.advice = "or --static for a trial in which the subject stands";
    }
  }

  void check_forces() {
    if (recording_.c3d) {
      append(findings_, find_force_rate_faults(*recording_.c3d));
      append(findings_, find_saturation(*recording_.c3d, platforms_.recordings));
      std::vector<ForcePlatform> platforms;
      for (const auto& plate : platforms_.recordings) platforms.push_back(plate.platform);
      append(findings_, find_force_spike_faults(*recording_.c3d, platforms));
      for (const ForcePlatformRecording& plate : platforms_.recordings) {
        append(findings_, find_baseline_faults(plate, inputs_.threshold));
      }
      signals_ = force_signals(platforms_.recordings);
      if (has_markers(recording_) && axes_.up.known()) {
        append(findings_, find_clock_faults(markers(), signals_, axes_.up.axis));
      }
    }
    if (recording_.table && !recording_.c3d) {
      append(findings_, find_force_spike_faults(*recording_.table));
    }
    if (!recording_.c3d && recording_.table && partner_) {
      const std::vector<ForceSignal> signals = force_signals(*recording_.table, inputs_.threshold);
      const LaboratoryAxes axes = find_axes(axis_evidence(*partner_->markers, std::nullopt, {}));
      if (signals.empty() || !axes.up.known()) return;
      append(findings_, find_clock_faults(*partner_->markers, signals, axes.up.axis));
    }
  }

  // The file's own events against those that its forces show.
  void check_events() {
    if (!axes_.up.known()) return;
    const std::vector<GaitEvent> by_file = events_from_file(recording_.c3d->events);
    const std::vector<GaitEvent> by_forces =
        events_from_forces(signals_, recording_.markers, axes_.up.axis);
    int compared = 0, other_side = 0;
    std::vector<std::string> times;
    for (const GaitEvent& event : by_file) {
      for (const GaitEvent& force : by_forces) {
        // Two frames of 60 Hz; the other foot's events are a fifth of a second away or more.
        const bool same = force.kind == event.kind && std::abs(force.time - event.time) < 0.035;
        if (!same || force.side == Side::kNone || event.side == Side::kNone) continue;
        ++compared;
        if (force.side == event.side) continue;
        ++other_side;
        times.push_back(time_text(event.time) + " s");
      }
    }
    if (other_side == 0) return;
    Finding& finding = add(
        Severity::kWarning, "side",
        fmt::format("{} of {} events of the file are of the other foot than the one that stands on "
                    "the platform then: {}",
                    other_side, compared, list_names(times)),
        0.8);
    finding.where = "EVENT:CONTEXTS";
    finding.flags = {"--events", "forces"};
    finding.advice = "replaces the file's events";
  }

  const PreflightRecording& recording_;
  const PreflightRecording* partner_;
  const PreflightInputs& inputs_;
  ForcePlatforms platforms_;
  std::vector<ForceSignal> signals_;
  LaboratoryAxes axes_;
  std::vector<Finding> findings_;
};

// The recording of markers that a table of forces belongs to: the one before it in the list, or
// else the first behind it; null if there is none or the table has no forces.
const PreflightRecording* partner_of(std::size_t index,
                                     const std::vector<PreflightRecording>& recordings) {
  const auto is_partner = [](const PreflightRecording& r) { return r.markers && !r.c3d; };
  for (std::size_t i = index; i-- > 0;) {
    if (is_partner(recordings[i])) return &recordings[i];
  }
  for (std::size_t i = index + 1; i < recordings.size(); ++i) {
    if (is_partner(recordings[i])) return &recordings[i];
  }
  return nullptr;
}

void add_reasons(std::vector<Finding>& findings, const std::string& file,
                 const std::vector<VerdictReason>& reasons) {
  for (const VerdictReason& reason : reasons) {
    findings.push_back(finding_of(reason));
    findings.back().file = file;
  }
}

// The static trial beside the others, and the mass that files say beside what platforms carry.
std::vector<Finding> check_subject(const PreflightInputs& inputs) {
  std::vector<Finding> findings;
  const PreflightRecording* standing =
      inputs.standing < 0 ? nullptr
                          : &inputs.recordings.at(static_cast<std::size_t>(inputs.standing));
  MassEvidence evidence;
  if (standing && standing->c3d) {
    evidence.carried =
        standing_mass(compute_forces(*standing->c3d, {.threshold = inputs.threshold}).recordings);
  }
  for (const PreflightRecording& recording : inputs.recordings) {
    if (standing && &recording != standing && recording.markers && standing->markers) {
      add_reasons(findings, standing->path,
                  static_trial_reasons(*standing->markers, *recording.markers));
    }
    if (!recording.c3d) continue;
    const SubjectParameters entered = subject_parameters(*recording.c3d);
    evidence.height = entered.height;
    if (!entered.mass) continue;
    add_reasons(findings, recording.path, mass_unit_reasons(*entered.mass, evidence));
  }
  return findings;
}

}  // namespace

PreflightRecording preflight_recording(const C3dFile& file) {
  PreflightRecording recording;
  recording.path = file.path;
  recording.markers = &file.markers;
  recording.metres_per_unit = file.metres_per_unit;
  recording.c3d = &file;
  recording.warnings = file.warnings;
  const auto& computed = file.computed.labels;
  for (std::string& label : find_texts(file.groups, "POINT", "LABELS")) {
    const bool is_marker = std::find(computed.begin(), computed.end(), label) == computed.end();
    if (is_marker) recording.labels.push_back(std::move(label));
  }
  return recording;
}

PreflightRecording preflight_recording(const MarkerFile& file, double metres_per_unit,
                                       std::vector<std::string> labels) {
  PreflightRecording recording;
  recording.path = file.path;
  recording.markers = &file.markers;
  recording.metres_per_unit = metres_per_unit;
  recording.labels = std::move(labels);
  recording.warnings = file.warnings;
  return recording;
}

PreflightRecording preflight_recording(const TimeTableFile& file) {
  PreflightRecording recording;
  recording.path = file.path;
  recording.table = &file.table;
  recording.warnings = file.warnings;
  return recording;
}

std::vector<Finding> run_preflight(const PreflightInputs& inputs) {
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < inputs.recordings.size(); ++i) {
    const PreflightRecording* partner = partner_of(i, inputs.recordings);
    append(findings, Check(inputs.recordings[i], partner, inputs).run());
  }
  append(findings, check_subject(inputs));
  return findings;
}

}  // namespace sinew
