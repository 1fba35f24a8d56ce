#include "model/osim_elements.h"

namespace sinew::osim {
namespace {

/// Appends the element of one kind of function, without its scale.
struct FunctionAppender {
  pugi::xml_node parent;
  const std::string& name;

  pugi::xml_node element(const char* class_name) const {
    pugi::xml_node node = pugi::xml_node(parent).append_child(class_name);
    if (!name.empty()) node.append_attribute("name").set_value(name.c_str());
    return node;
  }

  template <typename Points>
  pugi::xml_node points(const char* class_name, const Points& f) const {
    pugi::xml_node node = element(class_name);
    append_numbers(node, "x", f.x);
    append_numbers(node, "y", f.y);
    return node;
  }

  void operator()(const ConstantFunction& f) const {
    append_number(element("Constant"), "value", f.value);
  }
  void operator()(const LinearFunction& f) const {
    const double coefficients[] = {f.slope, f.intercept};
    append_numbers(element("LinearFunction"), "coefficients", coefficients);
  }
  void operator()(const PolynomialFunction& f) const {
    append_numbers(element("PolynomialFunction"), "coefficients", f.coefficients);
  }
  void operator()(const SineFunction& f) const {
    pugi::xml_node node = element("Sine");
    append_number(node, "amplitude", f.amplitude);
    append_number(node, "omega", f.omega);
    append_number(node, "phase", f.phase);
    append_number(node, "offset", f.offset);
  }
  void operator()(const SimmSpline& f) const { points("SimmSpline", f); }
  void operator()(const GcvSpline& f) const {
    pugi::xml_node node = points("GCVSpline", f);
    append_number(node, "half_order", f.half_order);
    append_number(node, "error_variance", 0.0);
  }
  void operator()(const PiecewiseLinearFunction& f) const { points("PiecewiseLinearFunction", f); }
  void operator()(const PiecewiseConstantFunction& f) const {
    points("PiecewiseConstantFunction", f);
  }
  void operator()(const StepFunction& f) const {
    pugi::xml_node node = element("StepFunction");
    append_number(node, "transition_start_time", f.start);
    append_number(node, "transition_end_time", f.end);
    append_number(node, "start_value", f.start_value);
    append_number(node, "end_value", f.end_value);
  }
};

}  // namespace

void append_function(pugi::xml_node parent, const ScalarFunction& function,
                     const std::string& name) {
  if (function.scale == 1.0) {
    std::visit(FunctionAppender{parent, name}, function.kind);
    return;
  }
  pugi::xml_node multiplier = FunctionAppender{parent, name}.element("MultiplierFunction");
  static const std::string kUnnamed;
  std::visit(FunctionAppender{multiplier.append_child("function"), kUnnamed}, function.kind);
  append_number(multiplier, "scale", function.scale);
}

}  // namespace sinew::osim
