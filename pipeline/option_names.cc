#include "pipeline/option_names.h"

#include <algorithm>
#include <regex>

namespace sinew {
namespace {

constexpr OptionName kNames[] = {
    {"WholeBodyOptions", "height", "--height"},
    {"WholeBodyOptions", "mass", "--mass"},
    {"ScaleOptions", "mass", "--mass"},
    {"MinimizerOptions", "method", "--method"},
    {"MinimizerOptions", "gradient_tolerance", "--gradient-tolerance"},
    {"MinimizerOptions", "time_limit", "--budget"},
    {"TrackingOptions", "threads", "--threads"},
    {"InverseDynamicsOptions", "threads", "--threads"},
    {"InverseDynamicsOptions", "cutoff", "--cutoff"},
    {"ExternalLoadsOptions", "cutoff", "--force-cutoff"},
    {"WireOptions", "penalty", "--wire-penalty"},
    {"WireOptions", "muscle_weight", "--muscle-weight"},
    {"WireOptions", "tendon_weight", "--tendon-weight"},
    {"WireOptions", "ligament_weight", "--ligament-weight"},
    {"WireOptions", "virtual_link_weight", "--virtual-link-weight"},
    {"AutoScaleOptions", "size_sd", "--size-sd"},
    {"AutoScaleOptions", "segment_sd", "--segment-sd"},
    {"AutoScaleOptions", "axis_sd", "--axis-sd"},
    {"AutoScaleOptions", "marker_offset_sd", "--offset-sd"},
    {"AutoScaleOptions", "technical_marker_sd", "--technical-sd"},
    {"AutoScaleOptions", "technical_markers", "--technical"},
    {"AutoScaleOptions", "marker_sd", "--marker-sd"},
    {"AutoScaleOptions", "posture_sd", "--posture-sd"},
    {"AutoScaleOptions", "independent_frames", "--independent-frames"},
    {"AutoScaleOptions", "frames", "--frames"},
    {"AutoScaleOptions", "groups", "--group"},
    {"AutoScaleOptions", "threads", "--threads"},
    {"GapFillOptions", "max_gap", "--max-gap"},
    {"ForcePlatformOptions", "threshold", "--threshold"},
    {"ReferenceRecordingOptions", "strides", "--strides"},
    {"MarkerArtifacts", "noise", "--noise"},
    {"MarkerArtifacts", "soft_tissue", "--soft-tissue"},
    {"MarkerArtifacts", "occlusion", "--occlusion"},
    {"MarkerArtifacts", "mislabels", "--mislabels"},
    {"C3dFile", "unit", "--unit"},
};

std::string in_words(const std::string& structure, std::string field) {
  for (const OptionName& name : kNames) {
    if (name.structure == structure && name.field == field) return std::string(name.option);
  }
  std::replace(field.begin(), field.end(), '_', ' ');
  return field;
}

}  // namespace

std::span<const OptionName> option_names() { return kNames; }

std::string in_words_of_options(const std::string& message) {
  // Files have a dot too, but no structure's name before it.
  static const std::regex kField(
      R"(\b([A-Z][A-Za-z0-9]*(?:Options|Artifacts)|C3dFile)(?:::|\.)([a-z][a-z0-9_]*))");
  std::string text;
  auto from = message.begin();
  for (std::sregex_iterator match(message.begin(), message.end(), kField), end; match != end;
       ++match) {
    text.append(from, message.begin() + match->position());
    text += in_words(match->str(1), match->str(2));
    from = message.begin() + match->position() + match->length();
  }
  return text.append(from, message.end());
}

}  // namespace sinew
