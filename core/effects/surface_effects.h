#pragma once

#include "core/effects/progressive_stiffness.h"
#include "core/effects/recorded_texture.h"
#include "core/effects/surface_bumps.h"
#include "core/effects/surface_drag.h"
#include "core/effects/surface_maps.h"
#include "core/effects/surface_snap.h"
#include "core/effects/surface_viscosity.h"
#include "core/effects/tap_vibration.h"
#include "core/effects/tissue_layers.h"

namespace hapton {

// What a surface does beyond the spring, damper and friction of its material. By default all is off. Units: SI. RT: yes.
struct SurfaceEffects {
  ProgressiveStiffness progressive = {};
  TissueLayers layers = {};  // in place of the material's spring; not together with progressive
  SurfaceBumps bumps = {};
  SurfaceViscosity viscosity = {};
  SurfaceSnap snap = {};
  TapVibration tap = {};
  SurfaceMaps maps = {};  // height not together with bumps, stiffness not with layers
  RecordedTexture texture = {};
  SurfaceDrag drag = {};  // set by TouchStep: what a method leaves out (not together with a friction map), and the stiffness in any case

  bool any() const noexcept {
    return progressive.is_on() || layers.is_on() || bumps.is_on() || viscosity.is_on() || snap.is_on() || tap.is_on() || maps.is_on() ||
           texture.is_on() || drag.is_on();
  }
};

// What the effects of one surface keep between two samples.
struct SurfaceEffectState {
  TissueLayers::State layers;
  SurfaceSnap::State snap;
  TapVibration::State tap;
};

}  // namespace hapton
