#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "data/xml_file.h"
#include "model/musculoskeletal_model.h"
#include "model/scaling.h"

namespace sinew {

/// An OpenSim model that is changed without losing anything that its file says. The document itself
/// is edited, rather than the description written anew: surfaces, contact, controllers, other
/// forces, geometry for display and comments, none of which the description holds, stay where they
/// are and are scaled where OpenSim scales them, and the document keeps its version. What
/// write_osim() makes would lack them all.
class OsimDocument {
 public:
  /// Throw InputError as read_osim() does.
  explicit OsimDocument(const std::filesystem::path& path);
  OsimDocument(std::string name, std::string content);

  /// The description of the document as it is now.
  const MusculoskeletalModel& model() const { return model_; }
  /// The document as it is now; see XmlFile::to_string().
  std::string to_string() const { return xml_->to_string(); }

  /// Names the model. Blanks and what else OpenSim refuses become underscores.
  void rename(const std::string& name);

  /// Adds the markers of a <MarkerSet> file; those with the name of one in the model replace it, as
  /// in OpenSim. Throws InputError for a file without markers or with a marker on a body that the
  /// model does not have.
  void merge_markers(const std::filesystem::path& marker_set);

  /// What scale_model() does to the description, and to what only the document has: offset frames,
  /// stations, wrap objects, attached geometry, bushings. Where offset frames stand turned on
  /// others this follows OpenSim, which scales each along its own parent's axes, and the
  /// description does not. Returns warnings of what stays as it was. Throws as scale_model() does.
  std::vector<Warning> scale(const ScaleFactors& factors, const ScaleOptions& options = {});

  /// Moves the markers to the places of `markers`, by name, and removes all others. Markers that
  /// have not moved are not touched.
  void set_markers(const std::vector<Marker>& markers);

 private:
  std::unique_ptr<XmlFile> xml_;
  MusculoskeletalModel model_;
};

/// A <MarkerSet> document of OpenSim 4 with the markers of `model`.
std::string write_marker_set(const MusculoskeletalModel& model);

}  // namespace sinew
