#pragma once

#define GL_GLEXT_PROTOTYPES
#include <GL/glcorearb.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "render/linear.h"
#include "render/shaders.h"
#include "render/sheet_shader.h"

// Provides classes that own OpenGL objects. Only gl_canvas.cc includes this file, so that one source file sees the
// OpenGL headers. All functions, destructors included, need a current context.
namespace kerf::render {

inline Status drawing_failed(const std::string& words) {
  return {StatusCode::kInternal, "DRAWING_FAILED", words, ""};
}

class Program {
 public:
  Program() = default;
  ~Program() { glDeleteProgram(id_); }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  Status build(const char* name, std::initializer_list<const char*> vertex,
               std::initializer_list<const char*> fragment);
  void use() const { glUseProgram(id_); }
  void set(const char* name, bool value) const { glUniform1i(at(name), value ? 1 : 0); }
  void set(const char* name, double value) const { glUniform1f(at(name), static_cast<float>(value)); }
  // Sets an array of uniforms of one number each, or of one vector each.
  void set(const char* name, const std::vector<float>& values) const {
    glUniform1fv(at(name), static_cast<GLsizei>(values.size()), values.data());
  }
  void set(const char* name, const std::vector<Vec3>& vectors) const {
    std::vector<float> numbers;
    for (const Vec3& v : vectors) {
      for (const double number : {v.x, v.y, v.z}) numbers.push_back(static_cast<float>(number));
    }
    glUniform3fv(at(name), static_cast<GLsizei>(vectors.size()), numbers.data());
  }
  void set(const char* name, double x, double y) const {
    glUniform2f(at(name), static_cast<float>(x), static_cast<float>(y));
  }
  void set(const char* name, Vec3 v) const {
    glUniform3f(at(name), static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z));
  }
  void set(const char* name, const Matrix4& matrix) const {
    std::array<float, 16> entries{};
    std::ranges::transform(matrix.entries, entries.begin(), [](double entry) { return static_cast<float>(entry); });
    glUniformMatrix4fv(at(name), 1, GL_FALSE, entries.data());
  }

 private:
  [[nodiscard]] GLint at(const char* name) const { return glGetUniformLocation(id_, name); }

  GLuint id_ = 0;
};

inline Status Program::build(const char* name, std::initializer_list<const char*> vertex,
                             std::initializer_list<const char*> fragment) {
  id_ = glCreateProgram();
  for (const auto& [stage, parts] : {std::pair{GL_VERTEX_SHADER, vertex}, std::pair{GL_FRAGMENT_SHADER, fragment}}) {
    std::vector<const char*> sources{kShaderVersion};
    sources.insert(sources.end(), parts.begin(), parts.end());
    const GLuint shader = glCreateShader(static_cast<GLenum>(stage));
    glShaderSource(shader, static_cast<GLsizei>(sources.size()), sources.data(), nullptr);
    glCompileShader(shader);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    std::array<char, 512> log{};
    if (compiled == GL_FALSE) glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glAttachShader(id_, shader);
    glDeleteShader(shader);
    if (compiled == GL_FALSE) return drawing_failed(std::string(name) + " shader: " + log.data());
  }
  glLinkProgram(id_);
  GLint linked = GL_FALSE;
  glGetProgramiv(id_, GL_LINK_STATUS, &linked);
  return linked == GL_TRUE ? Status{} : drawing_failed(std::string(name) + " program does not link");
}

// Represents a vertex array with one buffer of its own.
class VertexStream {
 public:
  VertexStream() {
    glGenVertexArrays(1, &array_);
    glGenBuffers(1, &buffer_);
  }
  ~VertexStream() {
    glDeleteBuffers(1, &buffer_);
    glDeleteVertexArrays(1, &array_);
  }
  VertexStream(const VertexStream&) = delete;
  VertexStream& operator=(const VertexStream&) = delete;

  struct Attribute {
    GLint components;
    GLenum type;
    std::size_t offset;  // bytes
  };
  // Sets the layout; attribute locations are 0, 1, ... in the order given. `divisor` is 0 for data per vertex, 1 for
  // data per instance.
  void set_layout(std::initializer_list<Attribute> attributes, std::size_t stride, GLuint divisor) const {
    bind();
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    GLuint location = 0;
    for (const Attribute& attribute : attributes) {
      glVertexAttribPointer(location, attribute.components, attribute.type,
                            attribute.type == GL_UNSIGNED_BYTE ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                            reinterpret_cast<const void*>(attribute.offset));  // NOLINT(performance-no-int-to-ptr)
      glVertexAttribDivisor(location, divisor);
      glEnableVertexAttribArray(location++);
    }
  }
  template <typename T>
  void upload(const std::vector<T>& data) const {
    glBindBuffer(GL_ARRAY_BUFFER, buffer_);
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), GL_STREAM_DRAW);
  }
  void bind() const { glBindVertexArray(array_); }
  // Draws the first `num_vertices` vertices as triangles.
  void draw(std::size_t num_vertices) const {
    bind();
    glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(num_vertices));
  }

 private:
  GLuint array_ = 0;
  GLuint buffer_ = 0;
};

// Represents a framebuffer with one colour buffer and optional depth.
class RenderTarget {
 public:
  RenderTarget() {
    glGenFramebuffers(1, &framebuffer_);
    glGenRenderbuffers(2, buffers_.data());
  }
  ~RenderTarget() {
    glDeleteRenderbuffers(2, buffers_.data());
    glDeleteFramebuffers(1, &framebuffer_);
  }
  RenderTarget(const RenderTarget&) = delete;
  RenderTarget& operator=(const RenderTarget&) = delete;

  // Resizes the buffers, with `samples` per pixel; 0 makes a plain buffer, from which pixels can be read.
  Status resize(int width, int height, int samples, bool with_depth) const {
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    attach(buffers_[0], GL_COLOR_ATTACHMENT0, GL_RGBA8, width, height, samples);
    if (with_depth) attach(buffers_[1], GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, width, height, samples);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return {};
    return drawing_failed("no framebuffer of " + std::to_string(width) + " x " + std::to_string(height) + " pixels");
  }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_; }

 private:
  static void attach(GLuint buffer, GLenum point, GLenum format, int width, int height, int samples) {
    glBindRenderbuffer(GL_RENDERBUFFER, buffer);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, buffer);
  }

  GLuint framebuffer_ = 0;
  std::array<GLuint, 2> buffers_{};
};

// Represents a square depth texture with comparison, and the framebuffer that fills it.
class ShadowMap {
 public:
  explicit ShadowMap(int size) : size_(size) {
    glGenTextures(1, &texture_);
    glBindTexture(GL_TEXTURE_2D, texture_);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
    for (const auto& [name, value] : {std::pair{GL_TEXTURE_MIN_FILTER, GL_LINEAR},
                                      {GL_TEXTURE_MAG_FILTER, GL_LINEAR},
                                      {GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE},
                                      {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE},
                                      {GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE},
                                      {GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL}}) {
      glTexParameteri(GL_TEXTURE_2D, static_cast<GLenum>(name), value);
    }
    glGenFramebuffers(1, &framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
  }
  ~ShadowMap() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteTextures(1, &texture_);
  }
  ShadowMap(const ShadowMap&) = delete;
  ShadowMap& operator=(const ShadowMap&) = delete;

  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] GLuint texture() const { return texture_; }
  [[nodiscard]] GLuint framebuffer() const { return framebuffer_; }

 private:
  int size_;
  GLuint texture_ = 0;
  GLuint framebuffer_ = 0;
};

}  // namespace kerf::render
