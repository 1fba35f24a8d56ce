#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <pugixml.hpp>
#include <span>
#include <string>

#include "model/musculoskeletal_model.h"

/// The parts of the .osim writer, shared by its source files only. Callers use model/osim_writer.h.
namespace sinew::osim {

/// <class_name name="name"> as last child of `parent`.
pugi::xml_node append_object(pugi::xml_node parent, const std::string& class_name,
                             const std::string& name);
/// <name>…</name> as last child of `parent`. Numbers are the shortest that read back the same.
void append_text(pugi::xml_node parent, const std::string& name, const std::string& text);
void append_number(pugi::xml_node parent, const std::string& name, double value);
void append_numbers(pugi::xml_node parent, const std::string& name, std::span<const double> values);
void append_vector(pugi::xml_node parent, const std::string& name, const Eigen::Vector3d& value);
void append_boolean(pugi::xml_node parent, const std::string& name, bool value);
/// <set_name><objects/></set_name>; returns <objects>.
pugi::xml_node append_set(pugi::xml_node parent, const std::string& set_name);
/// <PhysicalOffsetFrame name="name"> fixed on a body at X_BF.
void append_offset_frame(pugi::xml_node frames, const std::string& name,
                         const std::string& body_path, const RigidTransform& X_BF);

/// The function as <Class name="name">, or without the attribute where `name` is empty.
void append_function(pugi::xml_node parent, const ScalarFunction& function,
                     const std::string& name);

/// Paths of components in a document, such as /bodyset/tibia_r.
std::string body_path(const MusculoskeletalModel& model, int body);
std::string coordinate_path(const MusculoskeletalModel& model, int coordinate);
/// A coordinate's name within its joint: readers put `joint/` before a name that is not unique.
std::string name_in_joint(const MusculoskeletalModel& model, int coordinate);

/// `name` with an underscore for every character that OpenSim refuses.
std::string component_name(std::string name);

/// Throws InputError if OpenSim would refuse `name` for a component.
void require_component_name(const std::string& what, const std::string& name,
                            const SourceLocation& source);

/// A marker as version 4 has it.
void append_marker(pugi::xml_node objects, const MusculoskeletalModel& model, const Marker& marker);

void append_joints(pugi::xml_node model_node, const MusculoskeletalModel& model);
void append_forces(pugi::xml_node model_node, const MusculoskeletalModel& model);

}  // namespace sinew::osim
