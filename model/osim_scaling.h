#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "model/osim_reader.h"
#include "model/scaling.h"

/// Scaling of the elements of an .osim document. Callers use OsimDocument.
namespace sinew::osim {

/// Multiplies, in place, what grows with a body: walks over every element of the model and finds
/// the body that carries it by the reader's own table of frames.
class DocumentScaler {
 public:
  /// `xml`: parsed with Keep::kEverything. Throws InputError as the reader does.
  DocumentScaler(const XmlFile& xml, const ScaleFactors& factors);

  /// Places and sizes of all elements.
  void scale_places();
  /// Masses and inertias of bodies that are no virtual links.
  void scale_masses(const ScaleOptions& options);
  /// Fibre, tendon, resting and slack lengths of the paths, in the order of the description.
  void scale_lengths(std::span<const double> before, std::span<const double> after);

  const std::vector<Warning>& warnings() const { return warnings_; }

 private:
  const Eigen::Vector3d& factors_of(int body) const {
    return factors_.of_body[static_cast<std::size_t>(body)];
  }
  int body_of(const std::string& reference, const std::string& owner, pugi::xml_node node);
  void visit_members(pugi::xml_node set);
  void visit(pugi::xml_node node, const std::string& owner, int body);
  void visit_children(pugi::xml_node node, const std::string& owner, int body);
  bool scale_known(pugi::xml_node node, const std::string& owner, int& body);
  const Joint* find_joint(pugi::xml_node node, int body) const;
  void scale_joint(pugi::xml_node node, int body);
  void scale_shifts(pugi::xml_node joint_node, const Joint& joint);
  void scale_moving_point(pugi::xml_node node, const Eigen::Vector3d& f);
  void scale_coupler(pugi::xml_node node);
  void scale_two_bodies(pugi::xml_node node, const std::string& owner);
  void scale_wrap_object(pugi::xml_node node, const Eigen::Vector3d& f);
  void scale_geometry(pugi::xml_node frame, const Eigen::Vector3d& f);
  void grow(pugi::xml_node parent, const char* name, const Eigen::Vector3d& f);
  void grow(pugi::xml_node parent, const char* name, double factor);
  void report_unscaled();

  const XmlFile& xml_;
  const ScaleFactors& factors_;
  Reader reader_;
  std::map<std::string, std::vector<pugi::xml_node>> unscaled_;  // by class
  std::vector<Warning> warnings_;
};

/// The forces that have a path, in the order of MusculoskeletalModel::paths.
std::vector<pugi::xml_node> path_nodes(pugi::xml_node model_node);

/// Replaces the text of an element, leaving its comments.
void set_text(pugi::xml_node node, const std::string& text);
void set_numbers(pugi::xml_node node, std::span<const double> values);

}  // namespace sinew::osim
