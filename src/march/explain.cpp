#include "base/text.h"
#include "march/atlas_march.h"
#include "march/preintegration.h"
#include "psivox/parameters.h"

namespace psivox {
namespace {

std::string number(double value) { return formatted("%.4g", value); }

/// The view as if its light were in a grid already.
View with_light(View view) {
  if (!view.medium.light) return view;
  view.medium.light.reset();
  view.medium.lit_colors = view.medium.source == LuminanceSource::transfer;
  view.medium.source = LuminanceSource::vector;
  return view;
}

/// Explains from the constants that a view's march is compiled for.
class Model {
 public:
  Model(const View& view, const MediumAtlas& atlas)
      : view_(view),
        scene_(view.scene),
        medium_(view.medium),
        setup_(make_march_setup(with_light(view), atlas)) {
    march_.configure(setup_);
  }

  std::string grids() const {
    std::string text = in_quotes(medium_.density->name) + " is the density";
    if (medium_.luminance && !scene_.lit())
      text += "; " + in_quotes(medium_.luminance->name) + " shines";
    for (const Emission& emission : medium_.emission)
      text += "; " + in_quotes(emission.field->name) + " emits";
    const auto unread = [&](const std::string& name, bool used) {
      if (!name.empty() && !used)
        text += "; " + in_quotes(name) + " is not read: nothing depends on it";
    };
    unread(scene_.luminance_grid, scene_.shines());
    unread(scene_.temperature_grid, scene_.shines());
    for (const EmissionOptions& emission : emission_options)
      unread(scene_.*emission.grid, scene_.composites() && scene_.*emission.scale > 0);
    return text;
  }

  std::string volumes() const {
    if (medium_.others.empty()) return "one";
    std::string text = std::to_string(1 + medium_.others.size());
    text += ": the next by ";
    for (const Medium& other : medium_.others) {
      text += (&other == &medium_.others.front() ? "" : ", ") + in_quotes(other.density->name) +
              ", " + number(other.extinction) + " times its value";
      for (const Emission& emission : other.emission)
        text += ", and what " + in_quotes(emission.field->name) + " emits";
    }
    return text + "; a piece of a ray ends at the faces of each";
  }

  std::string attenuation() const {
    if (!scene_.attenuates()) return "none: --mode " + mode() + " looks at values alone";
    if (!constants().attenuates) return "none: the extinction is 0, so that no brick is stored";
    const std::string K = number(medium_.extinction);
    if (medium_.transfer)
      return K + " times the transfer function of the value, " +
             (constants().with_gradient ? "with the gradient's magnitude at voxels, " : "") +
             number(setup_.parameters.transfer_knots) + " knots" +
             (constants().split_knots ? ", at which cells are cut" : "");
    if (scene_.has_function()) return K + " times the voxels' function, interpolated";
    return K + " times the value";
  }

  std::string luminance() const {
    if (!scene_.composites()) return "none under --mode " + mode();
    if (!constants().attenuates) return "none: what does not attenuate does not shine";
    const std::string shadowed = " plus the light that reaches it";
    switch (medium_.source) {
      case LuminanceSource::constant:
        if (medium_.light) return "the light that reaches each voxel, computed once";
        if (constants().others_shine) return "constant in the first volume, and of each its own";
        return "constant: radiance is it times the opacity, and neither weights nor samples of it "
               "are "
               "computed";
      case LuminanceSource::density:
        return "the density's value, of the same sample" + (medium_.light ? shadowed : "");
      case LuminanceSource::transfer:
        return "the transfer function's colour, of the same sample" +
               (medium_.light ? std::string(", lit") : "");
      case LuminanceSource::scalar:
      case LuminanceSource::vector:
        break;
    }
    if (scene_.lit() && !medium_.light) return "the light that reaches each voxel, computed once";
    return medium_.source == LuminanceSource::scalar
               ? "a scalar grid: one more look-up a sample, one channel"
               : "a colour grid: one more look-up a sample, three channels";
  }

  std::string integrator() const {
    const IntegratorInfo& rule = info(constants().integrator);
    const std::string name = parameter_text(scene_, "integrator");
    if (!scene_.composites()) return "none under --mode " + mode();
    if (!constants().attenuates) return "none: emission adds up, by Simpson's rule";
    if (march_.depth_only)
      return "none: the picture depends on the optical depth alone, which is exact for what is "
             "interpolated (" +
             name + " would give the same)";
    return name + ": " + rule.help + table();
  }

  std::string sampling() const {
    if (constants().template_sampling) return "the voxels of one ray template, as asked";
    if (constants().uniform_sampling)
      return "uniform, every " + number(setup_.parameters.step) + " voxels";
    if (constants().cell_rule)
      return "cells, each in one piece or as many as its optical depth asks";
    if (march_.depth_only) return "cells, each in one step";
    return "cells, each in " + number(constants().segments) + " segments";
  }

  std::string corrections() const {
    if (constants().end_corrections) return "on: rays begin or end inside the medium";
    return "none: rays begin and end in vacuum, or the rule has none";
  }

  std::string early_end() const {
    if (!scene_.composites()) return "none under --mode " + mode();
    if (constants().ends_early)
      return "at an optical depth of " + number(setup_.parameters.stop_depth) +
             ", which rays may reach";
    return "none: no ray is that deep, or every one must be followed";
  }

  std::string holdout() const {
    if (!constants().holds_out) return "none";
    return "each ray ends at its pixel's depth, by " + in_quotes(scene_.holdout);
  }

  std::string emission() const {
    if (medium_.emission.empty()) return "none";
    std::string text = "quadratic between samples";
    if (constants().attenuates) text += ", seen through attenuation";
    for (const Emission& emission : medium_.emission)
      text += emission.field->channels == 3 ? ", three channels" : ", one channel";
    return text;
  }

  std::string light() const {
    if (!scene_.lit()) return "none";
    const std::string octaves = std::to_string(scene_.scatter_octaves);
    return (scene_.scatter_octaves == 1 ? "scattered once"
                                        : "scattered in " + octaves + " octaves") +
           ", computed at voxels" +
           (scene_.light_quality == LightQuality::exact ? ", exactly" : "") +
           (scene_.phase_g == 0 ? "; isotropic" : "; its phase by --phase-g");
  }

 private:
  /// Size and error of the table of `preintegrated`.
  std::string table() const {
    if (!setup_.preintegration) return "";
    const PreintegratedTable& made = *setup_.preintegration;
    return "; " + std::to_string(made.size()) + " x " + std::to_string(made.size()) + " values, " +
           std::to_string(made.layers()) + " lengths, off by " + number(made.error_bound()) +
           " of a segment's radiance at most";
  }

  const MarchConstants& constants() const { return setup_.constants; }
  std::string mode() const { return parameter_text(scene_, "mode"); }

  const View& view_;
  const Scene& scene_;
  const Medium& medium_;
  MarchSetup setup_;
  mutable glsl::AtlasMarch march_;  ///< its functions are not const, as in GLSL
};

}  // namespace

std::vector<Explanation> explain(const View& view, const MediumAtlas& atlas) {
  const Model model(view, atlas);
  std::vector<Explanation> explanations = {{"grids", model.grids()},
                                           {"volumes", model.volumes()},
                                           {"attenuation", model.attenuation()},
                                           {"luminance", model.luminance()},
                                           {"emission", model.emission()},
                                           {"light", model.light()},
                                           {"sampling", model.sampling()},
                                           {"integrator", model.integrator()},
                                           {"end corrections", model.corrections()},
                                           {"early end", model.early_end()},
                                           {"holdout", model.holdout()}};
  return explanations;
}

}  // namespace psivox
