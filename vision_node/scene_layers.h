#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "vision_node/gl_target.h"
#include "vision_node/scene_painter.h"
#include "vision_node/visible_depth.h"

namespace hapton {

// The static scene as each eye sees it, kept as a picture with depth: it is drawn again only when it looks different, in levels of detail
// while it moves, and then in full detail, part by part, while only the probe moves. Threads: the window's; its context is current, also
// in the destructor.
class SceneLayers {
 public:
  // Error: the driver rejects the shaders.
  static Result<std::unique_ptr<SceneLayers>> make(const std::vector<ShownObject>& objects, std::vector<SceneLight> lights = {});

  // passes: one for each eye that is shown. Draws again the pictures that do not match them any more, or that new levels would improve.
  void prepare(std::span<const ScenePass> passes, const GlFormat& format);

  // Like those of ScenePainter; the next prepare() draws all pictures again.
  void place_object(std::size_t object, const Pose& X_SO, bool is_shown);
  void reshape_object(std::size_t object, std::vector<Vec3> vertices);
  void replace_object(std::size_t object, std::vector<FlatLevel> levels);

  // Draws one more part in full detail. True when all eyes' pictures are complete; from then on copy_to_bound() shows them.
  bool refine();
  // Whether a picture shows less than full detail and all levels are made, so that refine() can improve it.
  bool wants_refining() const;
  // Draws full detail at once, for a picture that is kept.
  void refine_whole();

  // Copies the eye's picture with its depth into the framebuffer bound for drawing, from its pixel (x, y) on. Leaves OpenGL's state
  // unchanged.
  void copy_to_bound(Eye eye, int x, int y) const;

  // The visible point of the scene at a pixel (x, y) of the eye's picture, from the lower left corner. Frame W. Empty for the background,
  // outside the picture, and where read_surface() is null.
  std::optional<Vec3> find_surface(Eye eye, int x, int y) const;

  // The whole surface, read from the driver only if the eye's picture has changed. Null before the eye's first picture, between a change of
  // an object and the next prepare(), and with multisampling.
  std::shared_ptr<const VisibleDepth> read_surface(Eye eye);

  // Share of all levels of detail that has been made, 0 to 1.
  double progress() const { return painter_->progress(); }
  // True if new levels may look better than those shown.
  bool has_new_levels();
  // Counts of the picture that prepare() drew last, which is that of one eye.
  const PaintCount& count() const { return count_; }
  // Number of times an eye's picture of the scene has been drawn by prepare().
  std::uint64_t drawn() const { return pictures_drawn_; }

 private:
  struct Layer {
    ScenePass pass;
    GlTarget background;        // kept, because a copy is faster than drawing it
    ScenePass background_pass;  // the pass for which it was drawn
    GlTarget shown;
    GlTarget finer;                  // the picture in full detail that refine() draws part by part, and then swaps with `shown`
    PaintCursor cursor;              // where refine() continues in `finer`
    bool is_valid = false;           // `shown` matches `pass` and the objects
    bool is_active = false;          // among the newest passes
    bool is_full = false;            // `shown` has full detail
    bool is_finer_complete = false;  // `finer` is complete, and waits for the other eyes
    std::shared_ptr<const VisibleDepth> surface;  // null: not read yet
  };

  explicit SceneLayers(std::unique_ptr<ScenePainter> painter) : painter_(std::move(painter)) {}
  void begin(Layer& here, GlTarget& target);
  Layer& layer(Eye eye) { return layers_[static_cast<std::size_t>(eye)]; }

  std::unique_ptr<ScenePainter> painter_;
  std::array<Layer, 3> layers_;
  PaintCount count_;
  bool has_new_levels_ = false;
  std::uint64_t pictures_drawn_ = 0;
};

}  // namespace hapton
