#include "data/subject_parameters.h"

namespace sinew {
namespace {

std::optional<double> within(std::optional<double> value, double least, double most) {
  return value && *value >= least && *value <= most ? value : std::nullopt;
}

}  // namespace

SubjectParameters subject_parameters(const C3dFile& file) {
  if (find_number(file.groups, "SUBJECTS", "USED").value_or(1.0) > 1.0) return {};
  SubjectParameters subject;
  subject.mass = within(find_number(file.groups, "PROCESSING", "BODYMASS"), 3.0, 400.0);
  const std::optional<double> height = find_number(file.groups, "PROCESSING", "HEIGHT");
  subject.height = within(height, 0.3, 2.6);
  if (!subject.height && height) subject.height = within(1e-3 * *height, 0.3, 2.6);
  return subject;
}

}  // namespace sinew
