#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "vision_node/gl_target.h"
#include "vision_node/scene_painter.h"

namespace hapton {

// The static scene as each eye sees it, kept as a picture with depth: it is drawn again only when it looks different, in levels good enough
// to move, and then in full detail, part by part, while nothing but the probe moves. Threads: the window's; its context is current, at the
// end as well.
class SceneLayers {
 public:
  // Error: shaders the driver refuses.
  static Result<std::unique_ptr<SceneLayers>> make(const std::vector<ShownObject>& objects);

  // Draws those eyes' pictures that no longer show what the passes say. Leaves OpenGL as it was.
  void prepare(std::span<const ScenePass> passes, const GlFormat& format);

  // Draws one more part in full detail. True when all eyes' pictures are whole and from now on the ones that copy() shows.
  bool refine();
  // Whether the pictures show less than full detail, and more could be drawn.
  bool wants_refining() const;
  // All at once, for a picture that stays.
  void refine_whole();

  // The eye's picture with its depth into the framebuffer bound for drawing, from its pixel (x, y) on. Leaves OpenGL as it was.
  void copy_to_bound(Eye eye, int x, int y) const;

  // The place of the scene that is seen at a pixel of the eye's picture, frame W; none where there is only background, or no such pixel.
  std::optional<Vec3> find_surface(Eye eye, int x, int y) const;

  // How much of all levels of detail has been made, 0 to 1.
  double progress() const { return painter_->progress(); }
  // Levels have come that may look better than what is shown.
  bool has_new_levels();
  // Of the newest picture drawn in levels, one eye's.
  const PaintCount& count() const { return count_; }
  // How often an eye's picture of the scene has been drawn.
  std::uint64_t drawn() const { return drawn_; }

 private:
  struct Layer {
    ScenePass pass;
    GlTarget background;  // copied faster than drawn
    ScenePass background_pass;
    GlTarget shown;
    GlTarget finer;
    PaintCursor cursor;
    bool is_valid = false;
    bool is_active = false;  // among the newest passes
    bool is_full = false;
    bool is_finer_whole = false;
  };

  explicit SceneLayers(std::unique_ptr<ScenePainter> painter) : painter_(std::move(painter)) {}
  void begin(Layer& here, GlTarget& target);
  Layer& layer(Eye eye) { return layers_[static_cast<std::size_t>(eye)]; }

  std::unique_ptr<ScenePainter> painter_;
  std::array<Layer, 3> layers_;
  PaintCount count_;
  bool has_new_levels_ = false;
  std::uint64_t drawn_ = 0;
};

}  // namespace hapton
