#include "data/preflight_rate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "data/text.h"

namespace sinew {

std::vector<Finding> find_timing_faults(const MarkerTrajectories& markers,
                                        const MarkerCheckOptions& options) {
  using Severity = Finding::Severity;
  options.validate();
  std::vector<Finding> findings;
  const int frames = markers.frame_count();
  const auto add = [&](Severity severity, const char* kind, std::string text, double confidence) {
    Finding finding;
    finding.severity = severity;
    finding.kind = kind;
    finding.text = std::move(text);
    finding.confidence = confidence;
    findings.push_back(std::move(finding));
    return &findings.back();
  };
  if (frames == 0) return findings;
  if (const int first = markers.frame_numbers.front(); first != 1) {
    add(Severity::kNote, "first frame",
        fmt::format("the first frame has the number {}; its time is {} s", first,
                    time_text(markers.time[0])),
        1.0)
        ->advice = "--from and --to count seconds of these times";
  }
  if (markers.rate < options.least_rate) {
    add(Severity::kNote, "rate",
        fmt::format("{} frames per second leave heel strikes between two frames",
                    text::format_number(markers.rate)),
        0.9)
        ->advice = "record at 100 Hz or more";
  }
  if (frames < 3) return findings;
  const double mean = (markers.time[frames - 1] - markers.time[0]) / (frames - 1);
  int odd = 0, worst = 1;
  for (int f = 1; f < frames; ++f) {
    const auto off = [&](int g) { return std::abs(markers.time[g] - markers.time[g - 1] - mean); };
    if (off(f) > options.step_tolerance * mean) ++odd;
    if (off(f) > off(worst)) worst = f;
  }
  if (odd > 0) {
    Finding* finding =
        add(Severity::kWarning, "rate",
            fmt::format("{} of {} steps of time differ from the mean, {} s, by more than {:.0f} %; "
                        "one is {} s",
                        odd, frames - 1, time_text(mean), 100.0 * options.step_tolerance,
                        time_text(markers.time[worst] - markers.time[worst - 1])),
            0.95);
    set_frames(*finding, markers, worst - 1, worst);
    finding->flags = {"--rate", text::format_number(std::round(1.0 / mean))};
  }
  // Rates in headers are rounded to some digits, times to milliseconds.
  if (std::abs(markers.rate * mean - 1.0) > 0.02) {
    add(Severity::kWarning, "rate",
        fmt::format("the file's rate is {} Hz, its times step at {:.6g} Hz",
                    text::format_number(markers.rate), 1.0 / mean),
        0.95)
        ->flags = {"--rate", text::format_number(std::round(1.0 / mean))};
  }
  int missing = 0;
  for (std::size_t f = 1; f < markers.frame_numbers.size(); ++f) {
    missing += std::max(0, markers.frame_numbers[f] - markers.frame_numbers[f - 1] - 1);
  }
  if (missing > 0 && odd > 0) {
    add(Severity::kWarning, "rate", fmt::format("{} frame numbers are left out", missing), 0.95)
        ->flags = {"--rate", text::format_number(std::round(markers.rate))};
  }
  return findings;
}

}  // namespace sinew
