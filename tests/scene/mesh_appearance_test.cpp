#include "scene/mesh_appearance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scene/mesh_file.h"
#include "scene/scene_file.h"
#include "tests/scene/gltf/gltf_samples.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::string_view kPngBytes = "\x89PNG\r\n\x1a\n and no more";

using Rgb = std::array<std::uint8_t, 3>;

class MeshAppearances : public ::testing::Test {
 protected:
  MeshFile load(const std::string& name, const std::string& bytes, AppearanceReading appearance = AppearanceReading::on) {
    auto file = load_mesh_file(folder_.write(name, bytes), Unit::m, appearance);
    if (!file) {
      ADD_FAILURE() << file.error().what;
      return {};
    }
    return std::move(*file);
  }
  ScratchFolder folder_;
};

TEST(MeshAppearance, FlipsTextureCoordinatesVertically) {
  EXPECT_EQ(texcoord_of(0.25, 0.75), Eigen::Vector2f(0.25F, 0.25F));
  EXPECT_EQ(texcoord_of(-3.0, 2.0), Eigen::Vector2f(-3.0F, -1.0F));
  EXPECT_EQ(texcoord_of(NAN, 0.5), Eigen::Vector2f(0.0F, 0.0F));
  EXPECT_EQ(texcoord_of(0.5, 1e300), Eigen::Vector2f(0.0F, 0.0F));
}

TEST(MeshAppearance, TurnsLinearLightIntoSrgb) {
  EXPECT_EQ(to_srgb(0.0), 0.0F);
  EXPECT_EQ(to_srgb(1.0), 1.0F);
  EXPECT_NEAR(to_srgb(0.5), 0.7354, 1e-4);
  EXPECT_NEAR(to_srgb(0.002), 0.02584, 1e-5);
  EXPECT_EQ(to_srgb(NAN), 0.0F);
  EXPECT_EQ(to_srgb(7.0), 1.0F);
}

const std::string kObj =
    "mtllib all.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.25\n"
    "usemtl red\nf 1 2 3\nusemtl wood\nf 1/1 2/2 3/3 4/-1\n";

TEST_F(MeshAppearances, OfAnObjFileAreTheMaterialsItsTrianglesNameWithTheirTextures) {
  folder_.write("all.mtl", "newmtl red\nKd 0.8 0.1 0\n# no more\nnewmtl wood\nKd 0 0 0\nmap_Kd -s 1 1 1 pictures\\oak.png\n");
  std::filesystem::create_directory(folder_.path() / "pictures");
  folder_.write("pictures/oak.png", std::string(kPngBytes));
  const MeshFile file = load("a.obj", kObj);
  EXPECT_THAT(file.notes, IsEmpty());
  ASSERT_EQ(file.appearance.triangles.size(), 3U);
  const VisualMaterial& red = file.appearance.materials.at(file.appearance.triangles[0].material);
  ASSERT_TRUE(red.colour);
  EXPECT_EQ(*red.colour, Eigen::Vector3f(0.8F, 0.1F, 0.0F));
  EXPECT_FALSE(red.image);
  const VisualMaterial& wood = file.appearance.materials.at(file.appearance.triangles[2].material);
  EXPECT_FALSE(wood.colour) << "a colour beside an image is a default of the exporter";
  ASSERT_TRUE(wood.image);
  EXPECT_EQ(file.appearance.images.at(*wood.image).bytes, kPngBytes);
  // v is flipped, because OBJ files count it from the lower edge of the image.
  EXPECT_EQ(file.appearance.triangles[1].corners[0].texcoord, Eigen::Vector2f(0, 1));
  EXPECT_EQ(file.appearance.triangles[1].corners[2].texcoord, Eigen::Vector2f(1, 0));
  EXPECT_EQ(file.appearance.triangles[2].corners[2].texcoord, Eigen::Vector2f(0, 0.75F));
}

TEST_F(MeshAppearances, ImagesOfBumpsAreIgnoredWithANote) {
  folder_.write("all.mtl", "newmtl red\nKd 0.8 0.1 0\nmap_Bump -bm 0.3 a.png\nnewmtl wood\nnorm n.png\nnewmtl other\nbump b.png\n");
  const MeshFile file = load("a.obj", kObj);
  EXPECT_THAT(file.notes, ElementsAre(HasSubstr("2 images of bumps or normals are neither drawn nor felt")));
  folder_.write("all.mtl", "newmtl red\nKd 0.8 0.1 0\nnewmtl wood\n");
  EXPECT_THAT(load("b.obj", kObj).notes, IsEmpty());
}

TEST_F(MeshAppearances, AreReadOnlyOnRequest) {
  const MeshFile file = load("a.obj", kObj, AppearanceReading::off);
  EXPECT_TRUE(file.appearance.triangles.empty());
  EXPECT_THAT(file.notes, IsEmpty()) << "no note says that the library is missing";
}

TEST_F(MeshAppearances, WhatIsMissingIsANoteAndNoError) {
  EXPECT_THAT(load("a.obj", kObj).notes, Contains(HasSubstr("all.mtl")));
  folder_.write("all.mtl", "newmtl red\nKd 0.8 0.1 0\nnewmtl wood\nmap_Kd oak.png\n");
  EXPECT_THAT(load("a.obj", kObj).notes, Contains(HasSubstr("oak.png")));
}

TEST_F(MeshAppearances, OfAnObjFileAreItsVertexColours) {
  const MeshFile file = load("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 0.5\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
  ASSERT_EQ(file.appearance.triangles.size(), 2U);
  EXPECT_TRUE(file.appearance.triangles[0].has_colours);
  EXPECT_EQ(file.appearance.triangles[0].corners[0].colour, (Rgb{255, 0, 0}));
  EXPECT_EQ(file.appearance.triangles[0].corners[2].colour, (Rgb{0, 0, 128}));
  EXPECT_EQ(file.appearance.triangles[1].corners[2].colour, (Rgb{255, 255, 255}));
}

TEST_F(MeshAppearances, OfAPlyFileAreColoursAndATexture) {
  const std::string header =
      "ply\nformat ascii 1.0\ncomment TextureFile skin.png\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const MeshFile coloured = load("c.ply", header + "property uchar red\nproperty uchar green\nproperty uchar blue\n" + faces +
                                              "0 0 0 10 20 30\n1 0 0 40 50 60\n0 1 0 255 0 255\n3 0 1 2\n");
  ASSERT_EQ(coloured.appearance.triangles.size(), 1U);
  EXPECT_TRUE(coloured.appearance.triangles[0].has_colours);
  EXPECT_EQ(coloured.appearance.triangles[0].corners[0].colour, (Rgb{10, 20, 30}));
  EXPECT_EQ(coloured.appearance.triangles[0].corners[2].colour, (Rgb{255, 0, 255}));
  folder_.write("skin.png", std::string(kPngBytes));
  const MeshFile textured =
      load("t.ply", header + "property float s\nproperty float t\n" + faces + "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n");
  ASSERT_EQ(textured.appearance.triangles.size(), 1U);
  EXPECT_EQ(textured.appearance.materials.at(textured.appearance.triangles[0].material).image, 0U);
  EXPECT_EQ(textured.appearance.triangles[0].corners[2].texcoord, Eigen::Vector2f(0, 0));
  const MeshFile with_float_colours = load("f.ply", header + "property float red\nproperty float green\nproperty float blue\n" + faces +
                                                        "0 0 0 1 0.2 0\n1 0 0 0 0 0\n0 1 0 9 nan 0\n3 0 1 2\n");
  EXPECT_EQ(with_float_colours.appearance.triangles.at(0).corners[0].colour, (Rgb{255, 51, 0}));
  const MeshFile with_16_bit_colours = load("w.ply", header + "property ushort red\nproperty ushort green\nproperty ushort blue\n" + faces +
                                                         "0 0 0 65535 257 2570\n1 0 0 0 0 0\n0 1 0 0 0 0\n3 0 1 2\n");
  EXPECT_EQ(with_16_bit_colours.appearance.triangles.at(0).corners[0].colour, (Rgb{255, 1, 10}));
}

TEST_F(MeshAppearances, OfAPlyFileAreColoursOfFaces) {
  const std::string vertices = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  const std::string corners = "property list uchar int vertex_indices\n";
  const std::string points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
  for (const bool are_first : {false, true}) {
    const std::string faces = are_first ? "10 20 30 255 3 0 1 2\n40 50 60 255 3 0 2 3\n" : "3 0 1 2 10 20 30 255\n3 0 2 3 40 50 60 255\n";
    const MeshFile file = load(
        "f.ply", vertices + "element face 2\n" + (are_first ? colours + corners : corners + colours) + "end_header\n" + points + faces);
    ASSERT_EQ(file.appearance.triangles.size(), 2U);
    EXPECT_TRUE(file.appearance.triangles[0].has_colours);
    EXPECT_EQ(file.appearance.triangles[0].corners[2].colour, (Rgb{10, 20, 30}));
    EXPECT_EQ(file.appearance.triangles[1].corners[0].colour, (Rgb{40, 50, 60}));
  }
  const MeshFile with_both =
      load("b.ply", vertices + "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n" + corners + colours +
                        "end_header\n0 0 0 1 2 3\n1 0 0 4 5 6\n1 1 0 7 8 9\n0 1 0 0 0 0\n" + "3 0 1 2 10 20 30 255\n");
  EXPECT_EQ(with_both.appearance.triangles.at(0).corners[1].colour, (Rgb{4, 5, 6})) << "those of vertices are finer";
  const MeshFile without_colours = load("f.ply", vertices + "element face 1\n" + corners + "end_header\n" + points + "3 0 1 2\n");
  EXPECT_TRUE(without_colours.appearance.triangles.empty());
}

TEST_F(MeshAppearances, OfAPlyFileIsTheAlphaOfItsColours) {
  const std::string vertices = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string colours = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  const auto of_vertices = [&](int a, int b, int c) {
    return load("a.ply",
                vertices + colours + faces + fmt::format("end_header\n0 0 0 1 2 3 {}\n1 0 0 4 5 6 {}\n0 1 0 7 8 9 {}\n3 0 1 2\n", a, b, c));
  };
  const MeshFile file = of_vertices(0, 51, 255);
  const TriangleAppearance& appearance = file.appearance.triangles.at(0);
  EXPECT_EQ(appearance.corners[0].alpha, 0);
  EXPECT_EQ(appearance.corners[1].alpha, 51);
  EXPECT_EQ(appearance.corners[2].alpha, 255);
  EXPECT_EQ(appearance.corners[1].colour, (Rgb{4, 5, 6}));
  EXPECT_EQ(file.appearance.materials.at(appearance.material).alpha_mode, AlphaMode::blend);
  EXPECT_EQ(of_vertices(255, 255, 255).appearance.triangles.at(0).material, TriangleAppearance::kNoMaterial) << "nothing to blend";
  const MeshFile unset = of_vertices(0, 0, 0);
  EXPECT_EQ(unset.appearance.triangles.at(0).corners[0].alpha, 255);
  EXPECT_THAT(unset.notes, ElementsAre("the alpha of its colours is 0 everywhere, and is left out"));
  const MeshFile of_faces = load("f.ply", vertices + faces + colours + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 10 20 30 102\n");
  EXPECT_EQ(of_faces.appearance.triangles.at(0).corners[2].alpha, 102);
  EXPECT_EQ(of_faces.appearance.materials.at(of_faces.appearance.triangles[0].material).alpha_mode, AlphaMode::blend);
}

// MeshLab writes texture coordinates for each corner of a face.
TEST_F(MeshAppearances, OfAPlyFileAreTexturesOfItsFacesCorners) {
  folder_.write("a.png", std::string(kPngBytes));
  folder_.write("b.png", std::string(kPngBytes));
  const std::string begin =
      "ply\nformat ascii 1.0\ncomment TextureFile a.png\ncomment TextureFile b.png\n"
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
      "property list uchar int vertex_indices\n";
  const std::string points = "end_header\n0 0 0\n1 0 0\n0 1 0\n";
  const MeshFile file = load("w.ply", begin + "property list uchar float texcoord\nproperty int texnumber\n" + points +
                                          "3 0 1 2 6 0 0 1 0 0 0.25 1\n3 2 1 0 6 0 0 1 0 0 1 0\n3 0 1 2 0 0\n3 0 1 2 6 0 0 1 0 0 1 7\n");
  EXPECT_THAT(file.notes, IsEmpty());
  ASSERT_EQ(file.appearance.triangles.size(), 4U);
  EXPECT_EQ(file.appearance.materials.at(file.appearance.triangles[0].material).image, 1U);
  EXPECT_EQ(file.appearance.triangles[0].corners[2].texcoord, Eigen::Vector2f(0, 0.75F));
  EXPECT_EQ(file.appearance.materials.at(file.appearance.triangles[1].material).image, 0U);
  EXPECT_EQ(file.appearance.triangles[2].material, TriangleAppearance::kNoMaterial) << "it has no texture coordinates";
  EXPECT_EQ(file.appearance.triangles[3].material, TriangleAppearance::kNoMaterial) << "there is no such texture";
  const MeshFile nowhere = load("n.ply", begin + points + "3 0 1 2\n3 0 1 2\n3 0 1 2\n3 0 1 2\n");
  EXPECT_THAT(nowhere.notes, ElementsAre("its texture is not drawn: neither its vertices nor its faces have places in it"));
}

std::string appearance_floats(std::initializer_list<float> values) {
  std::string bytes;
  for (const float value : values) sample::append(bytes, value);
  return bytes;
}

// The tetrahedron with a texture whose image is in the GLB file.
std::string textured_glb(const std::string& material, const std::string& attributes = R"(,"TEXCOORD_0":2)",
                         const std::string& textures = R"("textures":[{"source":0}],)") {
  sample::Pieces pieces;
  const TriangleMesh mesh = sample::tetrahedron();
  pieces.add(sample::positions_of(mesh));
  pieces.add(sample::indices_of(mesh));
  pieces.add(appearance_floats({0, 0, 1, 0, 0, 1, 0.5F, 0.25F}));
  pieces.add(appearance_floats({1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1, 1, 1, 1, 0.5F}));
  pieces.add(std::string(kPngBytes));
  const std::string accessors = sample::accessors_of(mesh) + R"(,{"bufferView":2,"componentType":5126,"count":4,"type":"VEC2"})"
                                                             R"(,{"bufferView":3,"componentType":5126,"count":4,"type":"VEC4"})";
  return pieces.glb(accessors, R"("nodes":[{"mesh":0}],"images":[{"bufferView":4,"mimeType":"image/png"}],)" + textures +
                                   R"("materials":[)" + material + R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0)" +
                                   attributes + R"(},"indices":1,"material":0}]}])");
}

TEST_F(MeshAppearances, OfAGlbFileAreBaseColourAndTexture) {
  const MeshFile file =
      load("a.glb", textured_glb(R"({"pbrMetallicRoughness":{"baseColorFactor":[0.5,1,0,1],"baseColorTexture":{"index":0}}})"));
  EXPECT_THAT(file.notes, IsEmpty());
  ASSERT_EQ(file.appearance.triangles.size(), 4U);
  const VisualMaterial& material = file.appearance.materials.at(file.appearance.triangles[0].material);
  ASSERT_TRUE(material.image && material.colour);
  EXPECT_NEAR(material.colour->x(), 0.7354, 1e-4) << "linear light";
  EXPECT_EQ(file.appearance.images.at(*material.image).bytes.substr(0, kPngBytes.size()), kPngBytes);
  // Corners follow the triangles (0, 1, 2), (0, 3, 1) of the sample.
  EXPECT_EQ(file.appearance.triangles[0].corners[1].texcoord, Eigen::Vector2f(1, 0));
  EXPECT_EQ(file.appearance.triangles[1].corners[1].texcoord, Eigen::Vector2f(0.5F, 0.25F));
}

TEST_F(MeshAppearances, OfAGlbFileAreDiffuseColoursOfOlderMaterials) {
  const auto material = [&](const std::string& json) {
    const MeshFile file = load("a.glb", textured_glb(json));
    EXPECT_THAT(file.notes, IsEmpty());
    return file.appearance.materials.at(0);
  };
  const std::string extension = R"("extensions":{"KHR_materials_pbrSpecularGlossiness":)";
  const VisualMaterial both =
      material("{" + extension + R"({"diffuseFactor":[1,0,0,0.5],"diffuseTexture":{"index":0}}},"alphaMode":"BLEND"})");
  EXPECT_EQ(both.colour, Eigen::Vector3f(1, 0, 0));
  EXPECT_EQ(both.alpha, 0.5F);
  EXPECT_TRUE(both.image);
  const VisualMaterial metal = material("{" + extension + R"({"diffuseFactor":[0,0,0,1],"specularFactor":[1,0,1]}}})");
  EXPECT_EQ(metal.colour, Eigen::Vector3f(1, 0, 1)) << "metals have no diffuse colour";
  const VisualMaterial newer =
      material("{" + extension + R"({"diffuseFactor":[1,0,0,1]}},"pbrMetallicRoughness":{"baseColorFactor":[0,1,0,1]}})");
  EXPECT_EQ(newer.colour, Eigen::Vector3f(0, 1, 0));
}

TEST_F(MeshAppearances, OfAGlbFileIsTheLightOfBlackMaterialsAndTheRestIsNamed) {
  const MeshFile lamp = load("a.glb", textured_glb(R"({"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1]},"emissiveFactor":[0,0.5,0],)"
                                                   R"("emissiveTexture":{"index":0},)"
                                                   R"("extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":2}}})"));
  EXPECT_THAT(lamp.notes, IsEmpty());
  EXPECT_EQ(lamp.appearance.materials.at(0).colour, Eigen::Vector3f(0, 1, 0));
  EXPECT_TRUE(lamp.appearance.materials.at(0).image);
  for (const AppearanceReading appearance : {AppearanceReading::on, AppearanceReading::off}) {
    const MeshFile other = load("b.glb",
                                textured_glb(R"({"pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]},"emissiveFactor":[0,1,0],)"
                                             R"("extensions":{"KHR_materials_unlit":{},"KHR_materials_clearcoat":{}}})"),
                                appearance);
    EXPECT_THAT(other.notes, ElementsAre("the light that 1 materials emit (emissiveFactor) is not drawn",
                                         "its materials are drawn without KHR_materials_clearcoat, KHR_materials_unlit"));
  }
  EXPECT_THAT(load("c.glb", textured_glb(R"({"emissiveFactor":[0,0,0],"emissiveTexture":{"index":0}})")).notes, IsEmpty())
      << "the factor makes it dark";
}

TEST_F(MeshAppearances, OfAGlbFileAreItsVertexColoursAndItsTextureTransform) {
  const MeshFile file =
      load("a.glb", textured_glb(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":)"
                                 R"({"offset":[0.5,0.25],"scale":[2,4]}}}}})",
                                 R"(,"TEXCOORD_0":2,"COLOR_0":3)"));
  ASSERT_EQ(file.appearance.triangles.size(), 4U);
  EXPECT_EQ(file.appearance.triangles[0].corners[1].texcoord, Eigen::Vector2f(2.5F, 0.25F));
  EXPECT_TRUE(file.appearance.triangles[0].has_colours);
  EXPECT_EQ(file.appearance.triangles[0].corners[0].colour, (Rgb{255, 0, 0}));
  EXPECT_EQ(file.appearance.triangles[1].corners[1].colour, (Rgb{255, 255, 255}));
}

TEST_F(MeshAppearances, AGlbFileWhoseTextureIsMissingIsStillRead) {
  const MeshFile file = load("a.glb", textured_glb(R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":7}}})"));
  EXPECT_EQ(file.mesh.triangles.size(), 4U);
  EXPECT_THAT(file.notes, Contains(HasSubstr("a texture is missing")));
  EXPECT_FALSE(file.appearance.has_colours_or_images()) << "texture coordinates alone are no colours";
}

TEST_F(MeshAppearances, GoWithThePartsOfAFileAndStayOutOfTheHash) {
  folder_.write("all.mtl", "newmtl red\nKd 0.8 0.1 0\nnewmtl wood\nKd 0.3 0.2 0.1\n");
  folder_.write("a.obj", "mtllib all.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\no one\nusemtl red\nf 1 2 3\no two\nusemtl wood\nf 1 3 2\n");
  const auto path = folder_.write("s.toml", "[[object]]\nmesh = 'a.obj'\npart = 'two'\n[[object]]\nmesh = 'a.obj'\ncolor = [1, 0, 0]\n");
  const auto drawn_scene = load_scene(path, {.sealing = CrackSealing::off, .appearance = AppearanceReading::on});
  const auto touched_scene = load_scene(path);
  ASSERT_TRUE(drawn_scene && touched_scene);
  EXPECT_EQ(drawn_scene->given_hash, touched_scene->given_hash);
  ASSERT_TRUE(drawn_scene->objects[0].appearance);
  ASSERT_EQ(drawn_scene->objects[0].appearance->triangles.size(), 1U);
  EXPECT_EQ(drawn_scene->objects[0].appearance->materials.at(drawn_scene->objects[0].appearance->triangles[0].material).name, "wood");
  EXPECT_FALSE(drawn_scene->objects[1].appearance) << "the scene's colour is over the file's";
  EXPECT_FALSE(touched_scene->objects[0].appearance);
}

// Reading the appearance does not change how concave polygons are cut into triangles.
TEST_F(MeshAppearances, ChangeNoTriangle) {
  const std::string bytes = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1 4/1 5/1\n";
  const MeshFile with_appearance = load("a.obj", bytes);
  const MeshFile without_appearance = load("b.obj", bytes, AppearanceReading::off);
  EXPECT_EQ(with_appearance.mesh.triangles, without_appearance.mesh.triangles);
}

constexpr std::string_view kTexturedMaterial = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}})";

TEST_F(MeshAppearances, OfAGlbFileAreAlphaModeAndCutoff) {
  const auto material = [&](const std::string& json, const std::string& attributes = "") {
    const MeshFile file = load("a.glb", textured_glb(json, attributes));
    EXPECT_THAT(file.notes, IsEmpty());
    return file.appearance.materials.at(0);
  };
  const VisualMaterial opaque = material(R"({"pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]}})");
  EXPECT_EQ(opaque.alpha_mode, AlphaMode::opaque) << "glTF's default, whatever the factor";
  const VisualMaterial blend = material(R"({"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25]}})");
  EXPECT_EQ(blend.alpha_mode, AlphaMode::blend);
  EXPECT_EQ(blend.alpha, 0.25F) << "linear, no sRGB";
  const VisualMaterial mask = material(R"({"alphaMode":"MASK"})");
  EXPECT_EQ(mask.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(mask.alpha, 1.0F);
  EXPECT_EQ(mask.alpha_cutoff, 0.5F);
  EXPECT_EQ(material(R"({"alphaMode":"MASK","alphaCutoff":0.75})").alpha_cutoff, 0.75F);
  EXPECT_FALSE(material(R"({"alphaMode":"MASK"})").is_double_sided);
  EXPECT_TRUE(material(R"({"alphaMode":"MASK","doubleSided":true})").is_double_sided);
  EXPECT_FALSE(material(R"({"alphaMode":"MASK","doubleSided":"true"})").is_double_sided);
  EXPECT_GT(material(R"({"alphaMode":"MASK","alphaCutoff":1e300})").alpha_cutoff, 1.0F);
  EXPECT_TRUE(load("a.glb", textured_glb(R"({"alphaMode":"BLEND"})")).appearance.has_colours_or_images());
}

TEST_F(MeshAppearances, OfAGlbFileAreTheAlphasOfItsVertices) {
  const MeshFile file = load("a.glb", textured_glb(R"({"alphaMode":"BLEND"})", R"(,"COLOR_0":3)"));
  ASSERT_EQ(file.appearance.triangles.size(), 4U);
  EXPECT_EQ(file.appearance.triangles[0].corners[0].alpha, 255);
  EXPECT_EQ(file.appearance.triangles[1].corners[1].alpha, 128);
}

TEST_F(MeshAppearances, AlphaThatMakesNoSenseIsANote) {
  const MeshFile mode = load("a.glb", textured_glb(R"({"alphaMode":"GLASS"})"));
  EXPECT_THAT(mode.notes, Contains(HasSubstr("materials[0].alphaMode")));
  EXPECT_TRUE(mode.appearance.triangles.empty() || mode.appearance.materials.at(0).alpha_mode == AlphaMode::opaque);
  for (const std::string cutoff : {"-0.5", "\"half\""}) {
    const MeshFile file = load("a.glb", textured_glb(R"({"alphaMode":"MASK","alphaCutoff":)" + cutoff + "}"));
    EXPECT_THAT(file.notes, Contains(HasSubstr("materials[0].alphaCutoff"))) << cutoff;
    EXPECT_EQ(file.appearance.materials.at(0).alpha_cutoff, 0.5F);
  }
}

// textured_glb() with this sampler. index: the sampler that its only texture names; it may not exist.
std::string textured_glb_with_sampler(const std::string& sampler, const std::string& index = "0") {
  return textured_glb(std::string(kTexturedMaterial), R"(,"TEXCOORD_0":2)",
                      R"("textures":[{"source":0,"sampler":)" + index + R"(}],"samplers":[)" + sampler + "],");
}

TEST_F(MeshAppearances, OfAGlbFileAreTheWrapModesOfItsSamplers) {
  using Wraps = std::array<TextureWrap, 2>;
  const auto wraps = [&](const std::string& sampler) {
    const MeshFile file = load("a.glb", textured_glb_with_sampler(sampler));
    EXPECT_THAT(file.notes, IsEmpty());
    return file.appearance.materials.at(0).wrap;
  };
  EXPECT_EQ(load("a.glb", textured_glb(std::string(kTexturedMaterial))).appearance.materials.at(0).wrap, (Wraps{}));
  EXPECT_EQ(wraps("{}"), (Wraps{TextureWrap::repeat, TextureWrap::repeat}));
  EXPECT_EQ(wraps(R"({"wrapS":33071,"wrapT":33648})"), (Wraps{TextureWrap::clamp, TextureWrap::mirror}));
  EXPECT_EQ(wraps(R"({"wrapS":10497,"wrapT":33071})"), (Wraps{TextureWrap::repeat, TextureWrap::clamp}));
  EXPECT_THAT(load("a.glb", textured_glb_with_sampler(R"({"wrapS":1})")).notes, Contains(HasSubstr("samplers[0].wrapS")));
  EXPECT_THAT(load("a.glb", textured_glb_with_sampler("{}", "3")).notes, Contains(HasSubstr("a texture repeats")));
}

TEST_F(MeshAppearances, OfAnObjFileAreOpacitiesAndClampedTextures) {
  folder_.write("oak.png", std::string(kPngBytes));
  const auto wood = [&](const std::string& lines) {
    folder_.write("all.mtl", "newmtl red\nd 0.1\nnewmtl wood\n" + lines);
    const MeshFile file = load("a.obj", kObj);
    EXPECT_THAT(file.notes, IsEmpty());
    return file.appearance.materials.at(1);
  };
  EXPECT_EQ(wood("Kd 1 1 1\n").alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(wood("d 0.25\n").alpha, 0.25F);
  EXPECT_EQ(wood("d 0.25\n").alpha_mode, AlphaMode::blend);
  EXPECT_EQ(wood("d -halo 0.25\n").alpha, 0.25F);
  EXPECT_EQ(wood("Tr 0.25\n").alpha, 0.75F);
  EXPECT_EQ(wood("d 1\nTr 1\n").alpha_mode, AlphaMode::opaque) << "some exporters mean d by Tr; d is never in doubt";
  EXPECT_EQ(wood("Tr 1\nd 1\n").alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(wood("d none\n").alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(wood("d 7\n").alpha_mode, AlphaMode::opaque);
  EXPECT_EQ(wood("map_Kd oak.png\n").wrap[0], TextureWrap::repeat);
  EXPECT_EQ(wood("map_Kd -s 2 2 1 -clamp on oak.png\n").wrap, (std::array{TextureWrap::clamp, TextureWrap::clamp}));
  EXPECT_EQ(wood("map_Kd -clamp off oak.png\n").wrap[1], TextureWrap::repeat);
}

TEST_F(MeshAppearances, OfAnObjFileAreThePlacesOfItsImages) {
  folder_.write("oak.png", std::string(kPngBytes));
  const auto wood = [&](const std::string& line) {
    folder_.write("all.mtl", "newmtl red\nnewmtl wood\n" + line);
    const MeshFile file = load("a.obj", kObj);
    EXPECT_THAT(file.notes, IsEmpty());
    return file.appearance.materials.at(1);
  };
  EXPECT_EQ(wood("map_Kd oak.png\n").image_scale, Eigen::Vector2f(1, 1));
  EXPECT_EQ(wood("map_Kd oak.png\n").image_shift, Eigen::Vector2f(0, 0));
  // The corner (0.5, 0.25) becomes (4 u + 0.125, 2 v + 0.5) = (2.125, 1). Counted downwards, v = 0.25 is 0.75 and v = 1 is 0.
  const VisualMaterial tiled = wood("map_Kd -s 4 2 1 -o 0.125 0.5 0 oak.png\n");
  const Eigen::Vector2f placed = Eigen::Vector2f(0.5F, 0.75F).cwiseProduct(tiled.image_scale) + tiled.image_shift;
  EXPECT_EQ(placed, Eigen::Vector2f(2.125F, 0.0F));
  EXPECT_TRUE(tiled.image);
  EXPECT_EQ(wood("map_Kd -s 3 oak.png\n").image_scale, Eigen::Vector2f(3, 1)) << "what is left out stays";
  EXPECT_EQ(wood("map_Kd -o 0.5 -s 3 2 oak.png\n").image_scale, Eigen::Vector2f(3, 2));
  EXPECT_EQ(wood("map_Kd -s none oak.png\n").image_scale, Eigen::Vector2f(1, 1));
}

TEST_F(MeshAppearances, OfAnObjFileAreImagesWhateverTheirNames) {
  folder_.write("red oak.png", std::string(kPngBytes));
  const auto wood = [&](const std::string& line) {
    folder_.write("all.mtl", "newmtl red\nnewmtl wood\n" + line + "\n");
    const MeshFile file = load("a.obj", kObj);
    EXPECT_THAT(file.notes, IsEmpty()) << line;
    return file.appearance.materials.at(1);
  };
  for (const std::string line :
       {"map_Kd red oak.png", "map_Kd \"red oak.png\"", "map_Kd 'red oak.png'", "map_Kd -s 2 2 1 -o 0 0 0 red oak.png",
        "map_Kd -bm 0.5 -blendu on -mm 0 1 -texres 512 red oak.png", "map_Kd -t 0 0 0 -imfchan l \"red oak.png\"",
        "map_Kd -clamp on red oak.png ", "map_Kd C:\\work\\red oak.png", "map_Kd /somewhere else/red oak.png"}) {
    const VisualMaterial material = wood(line);
    EXPECT_TRUE(material.image) << line;
    EXPECT_EQ(material.image_scale.x(), line.find("-s 2") != std::string::npos ? 2.0F : 1.0F) << line;
    EXPECT_EQ(material.wrap[0], line.find("-clamp") != std::string::npos ? TextureWrap::clamp : TextureWrap::repeat) << line;
  }
  folder_.write("7", std::string(kPngBytes));
  EXPECT_TRUE(wood("map_Kd -s 2 7").image) << "the last word is the name";
  folder_.write("oak.png", std::string(kPngBytes));
  EXPECT_TRUE(wood("map_Kd -unknown 3 oak.png").image);
  folder_.write("all.mtl", "newmtl red\nnewmtl wood\nmap_Kd -s 1 1 1 green oak.png\n");
  EXPECT_THAT(load("a.obj", kObj).notes, ElementsAre("a texture is missing: 'green oak.png' cannot be read"));
}

TEST_F(MeshAppearances, OfAnObjFileAreAllItsLibraries) {
  const std::string mesh = kObj.substr(kObj.find('\n') + 1);
  folder_.write("my red.mtl", "newmtl red\nKd 1 0 0\n");
  folder_.write("red.mtl", "newmtl red\nKd 1 0 0\n");
  folder_.write("wood.mtl", "newmtl wood\nKd 0 1 0\n");
  for (const char* lines :
       {"mtllib red.mtl wood.mtl\n", "mtllib \"my red.mtl\"\nmtllib wood.mtl\n", "mtllib my red.mtl\nmtllib wood.mtl\n"}) {
    const MeshFile file = load("a.obj", lines + mesh);
    EXPECT_THAT(file.notes, IsEmpty()) << lines;
    EXPECT_EQ(file.appearance.materials.at(0).colour, Eigen::Vector3f(1, 0, 0)) << lines;
    EXPECT_EQ(file.appearance.materials.at(1).colour, Eigen::Vector3f(0, 1, 0)) << lines;
  }
  folder_.write("red.mtl", "newmtl red\nbump b.png\n");
  EXPECT_THAT(load("a.obj", "mtllib red.mtl\nmtllib wood.mtl red.mtl\nmtllib red.mtl\n" + mesh).notes, testing::SizeIs(1)) << "each once";
}

TEST_F(MeshAppearances, LightThatMaterialsOfAnObjFileEmitIsNamed) {
  folder_.write("all.mtl", "newmtl red\nKd 1 0 0\nKe 0 0 0\nnewmtl wood\nKe 0 0.5 0\nmap_Ke a.png\n");
  EXPECT_THAT(load("a.obj", kObj).notes, ElementsAre("the light that 1 materials emit (Ke, map_Ke) is not drawn"));
}

TEST_F(MeshAppearances, TheColourBesideAnImageIsKeptForOneThatCannotBeDecoded) {
  folder_.write("oak.png", std::string(kPngBytes));
  for (const char* lines : {"Kd 0.25 0.5 1\nmap_Kd oak.png\n", "map_Kd oak.png\nKd 0.25 0.5 1\n"}) {
    folder_.write("all.mtl", std::string("newmtl red\nnewmtl wood\n") + lines);
    const VisualMaterial wood = load("a.obj", kObj).appearance.materials.at(1);
    EXPECT_FALSE(wood.colour);
    EXPECT_EQ(wood.colour_no_image.value_or(Eigen::Vector3f::Zero()), Eigen::Vector3f(0.25F, 0.5F, 1.0F)) << lines;
  }
}

TEST_F(MeshAppearances, MaterialsThatNoLibraryHasAreNamed) {
  folder_.write("all.mtl", "newmtl wood\nKd 1 1 1\n");
  EXPECT_THAT(load("a.obj", kObj).notes, ElementsAre("material 'red' is in no material library that could be read: it has no colour"));
  folder_.write("all.mtl", "newmtl Wood\nKd 1 1 1\n");
  EXPECT_THAT(load("a.obj", kObj).notes,
              ElementsAre("material 'red', as 2 in all, is in no material library that could be read: it has no colour"));
}

}  // namespace
}  // namespace hapton
