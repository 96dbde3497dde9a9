// vision_node runs for hours, and meshes are reshaped and their levels of detail replaced again and again: the graphics driver must release
// what is no longer drawn.
#include "vision_node/flat_buffers.h"

#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <thread>
#include <vector>

#include <GL/glew.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/vision_node/made_views.h"
#include "vision_node/gl_program.h"
#include "vision_node/gl_target.h"
#include "vision_node/scene_layers.h"
#include "vision_node/scene_painter.h"

namespace hapton {
namespace {

struct DriverMemory : testing::Test {
  // Opens a view, which makes its OpenGL context current: the tests make all objects in this context.
  void SetUp() override {
    view = open_or_fail(plain_settings(StereoMode::mono, 64, 64), {});
    ASSERT_TRUE(view);
    objects_before = count_objects();
  }
  // Counts the OpenGL objects of all kinds that the program itself must release. Their names begin with 1.
  static int count_objects() {
    int count = 0;
    for (GLuint name = 1; name < 4096; ++name) {
      count += glIsVertexArray(name) + glIsBuffer(name) + glIsTexture(name) + glIsRenderbuffer(name) + glIsFramebuffer(name) +
               glIsProgram(name) + glIsShader(name);
    }
    return count;
  }
  static FlatLevel make_level(bool is_painted) {
    FlatLevel level;
    level.vertices.resize(3);
    level.indices = {0, 1, 2};
    if (is_painted) level.paints.resize(3);
    return level;
  }

  std::unique_ptr<StereoView> view;
  int objects_before = 0;
};

TEST_F(DriverMemory, ALevelOfDetailThatIsReleasedLeavesNothing) {
  for (const bool is_painted : {false, true}) {
    FlatBuffers buffers = upload(make_level(is_painted), 0);
    // A vertex array and a buffer of vertices, and one of paint.
    EXPECT_EQ(count_objects(), objects_before + (is_painted ? 3 : 2));
    release(buffers);
    EXPECT_EQ(count_objects(), objects_before);
    release(buffers);  // nothing is left to release
    EXPECT_EQ(count_objects(), objects_before);
  }
}

TEST_F(DriverMemory, AReshapedMeshReplacesTheOneBefore) {
  const auto ball = make_marker(Vec3::Zero(), 0.05);
  auto painter = ScenePainter::make({ShownObject{.mesh = ball}});
  ASSERT_TRUE(painter) << painter.error().what;
  (*painter)->reshape_object(0, ball->vertices);
  const int objects_in_use = count_objects();
  EXPECT_GT(objects_in_use, objects_before);
  for (int i = 0; i < 5; ++i) (*painter)->reshape_object(0, ball->vertices);
  EXPECT_EQ(count_objects(), objects_in_use);
  painter->reset();
  EXPECT_EQ(count_objects(), objects_before) << "the painter releases everything";
}

TEST_F(DriverMemory, AFramebufferOfAnotherSizeReplacesTheOneBefore) {
  const GlStateGuard guard;
  {
    GlTarget target;
    EXPECT_TRUE(target.resize({32, 16}, {}));
    const int objects_in_use = count_objects();
    EXPECT_EQ(objects_in_use, objects_before + 3);  // the framebuffer, its colour and its depth
    EXPECT_FALSE(target.resize({32, 16}, {})) << "its content is kept";
    EXPECT_TRUE(target.resize({16, 32}, {}));
    EXPECT_EQ(count_objects(), objects_in_use);
  }
  EXPECT_EQ(count_objects(), objects_before);
}

// VTK keeps a copy of the state that it has set, and draws wrongly where OpenGL has another state.
TEST_F(DriverMemory, WhatIsSetInAScopeIsAsItWasAfterIt) {
  const auto read_state = [] {
    std::map<GLenum, std::array<GLfloat, 4>> values;
    for (const GLenum name : {GL_DRAW_FRAMEBUFFER_BINDING,
                              GL_READ_FRAMEBUFFER_BINDING,
                              GL_CURRENT_PROGRAM,
                              GL_VERTEX_ARRAY_BINDING,
                              GL_ARRAY_BUFFER_BINDING,
                              GL_DEPTH_FUNC,
                              GL_CULL_FACE_MODE,
                              GL_FRONT_FACE,
                              GL_VIEWPORT,
                              GL_SCISSOR_BOX,
                              GL_COLOR_CLEAR_VALUE,
                              GL_LINE_WIDTH,
                              GL_DEPTH_WRITEMASK,
                              GL_COLOR_WRITEMASK,
                              GL_BLEND_SRC_RGB,
                              GL_BLEND_DST_RGB,
                              GL_BLEND_SRC_ALPHA,
                              GL_BLEND_DST_ALPHA,
                              GL_SCISSOR_TEST,
                              GL_DEPTH_TEST,
                              GL_BLEND,
                              GL_CULL_FACE}) {
      values[name] = {};
      glGetFloatv(name, values[name].data());
    }
    return values;
  };
  const auto program = GlProgram::make("#version 150\nin vec3 position;\nvoid main() { gl_Position = vec4(position, 1.0); }\n",
                                       "#version 150\nout vec4 colour;\nvoid main() { colour = vec4(1.0); }\n");
  ASSERT_TRUE(program) << program.error().what;
  // Every value differs from the one that is set below.
  glUseProgram(0);
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glDepthFunc(GL_LEQUAL);
  glCullFace(GL_BACK);
  glFrontFace(GL_CCW);
  glViewport(0, 0, 64, 64);
  glScissor(0, 0, 64, 64);
  glClearColor(0.1F, 0.1F, 0.1F, 1.0F);
  glLineWidth(1.0F);
  glDepthMask(GL_TRUE);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glEnable(GL_CULL_FACE);
  const auto as_it_was = read_state();
  GlTarget target;
  FlatBuffers buffers;
  {
    const GlStateGuard guard;
    target.resize({32, 16}, {});
    target.bind();
    buffers = upload(make_level(false), 0);
    program->use();
    glBindVertexArray(buffers.array);
    glBindBuffer(GL_ARRAY_BUFFER, buffers.buffer);
    glDepthFunc(GL_ALWAYS);
    glCullFace(GL_FRONT);
    glFrontFace(GL_CW);
    glViewport(1, 2, 3, 4);
    glScissor(5, 6, 7, 8);
    glClearColor(0.2F, 0.4F, 0.6F, 0.8F);
    glLineWidth(0.5F);
    glDepthMask(GL_FALSE);
    glColorMask(GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glBlendFuncSeparate(GL_ONE, GL_ZERO, GL_DST_COLOR, GL_SRC_COLOR);
    glEnable(GL_SCISSOR_TEST);
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glDisable(GL_CULL_FACE);
    for (const auto& [name, value] : read_state()) EXPECT_NE(value, as_it_was.at(name)) << "state " << name << " is not set here";
  }
  for (const auto& [name, value] : read_state()) EXPECT_EQ(value, as_it_was.at(name)) << "state " << name;
  release(buffers);
}

// New levels are uploaded in the middle of a frame of VTK, even if no picture of the scene is drawn in it.
TEST_F(DriverMemory, NewLevelsOfDetailLeaveWhatIsBound) {
  const auto mesh = std::make_shared<TriangleMesh>(make_bumpy_sphere(0.05, 0.25, 15'000, 1));
  auto layers = SceneLayers::make({ShownObject{.mesh = mesh}});
  ASSERT_TRUE(layers) << layers.error().what;
  // Waits five minutes at most, like wait_for_levels().
  for (int n = 0; n < 30'000 && (*layers)->progress() < 1.0; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  GLuint buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  const int objects_in_use = count_objects();
  (*layers)->prepare({}, {});
  EXPECT_GT(count_objects(), objects_in_use) << "levels have come";
  GLint bound = 0;
  glGetIntegerv(GL_ARRAY_BUFFER_BINDING, &bound);
  EXPECT_EQ(static_cast<GLuint>(bound), buffer);
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glDeleteBuffers(1, &buffer);
}

}  // namespace
}  // namespace hapton
