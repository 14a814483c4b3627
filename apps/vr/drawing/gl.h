// The functions of OpenGL ES 3 that drawing needs, as they are found while the program runs: nothing links to a library
// of OpenGL, so programs start where there is none. Private to drawing.
//
// Thread safety: constant once loaded.
#pragma once

#include <GLES3/gl3.h>

namespace ctn::vr::drawing {

// Names as in glClear(), and as in the type PFNGLCLEARPROC.
#define CTN_VR_GL_FUNCTIONS(X)                        \
  X(ActiveTexture, ACTIVETEXTURE)                     \
  X(AttachShader, ATTACHSHADER)                       \
  X(BindBuffer, BINDBUFFER)                           \
  X(BindFramebuffer, BINDFRAMEBUFFER)                 \
  X(BindRenderbuffer, BINDRENDERBUFFER)               \
  X(BindTexture, BINDTEXTURE)                         \
  X(BindVertexArray, BINDVERTEXARRAY)                 \
  X(BufferData, BUFFERDATA)                           \
  X(CheckFramebufferStatus, CHECKFRAMEBUFFERSTATUS)   \
  X(Clear, CLEAR)                                     \
  X(ClearColor, CLEARCOLOR)                           \
  X(CompileShader, COMPILESHADER)                     \
  X(CreateProgram, CREATEPROGRAM)                     \
  X(CreateShader, CREATESHADER)                       \
  X(DeleteShader, DELETESHADER)                       \
  X(Disable, DISABLE)                                 \
  X(DrawArrays, DRAWARRAYS)                           \
  X(DrawElements, DRAWELEMENTS)                       \
  X(Enable, ENABLE)                                   \
  X(EnableVertexAttribArray, ENABLEVERTEXATTRIBARRAY) \
  X(Finish, FINISH)                                   \
  X(FramebufferRenderbuffer, FRAMEBUFFERRENDERBUFFER) \
  X(FramebufferTexture2D, FRAMEBUFFERTEXTURE2D)       \
  X(GenBuffers, GENBUFFERS)                           \
  X(GenFramebuffers, GENFRAMEBUFFERS)                 \
  X(GenRenderbuffers, GENRENDERBUFFERS)               \
  X(GenTextures, GENTEXTURES)                         \
  X(GenVertexArrays, GENVERTEXARRAYS)                 \
  X(GenerateMipmap, GENERATEMIPMAP)                   \
  X(GetProgramInfoLog, GETPROGRAMINFOLOG)             \
  X(GetProgramiv, GETPROGRAMIV)                       \
  X(GetShaderInfoLog, GETSHADERINFOLOG)               \
  X(GetShaderiv, GETSHADERIV)                         \
  X(GetString, GETSTRING)                             \
  X(GetUniformLocation, GETUNIFORMLOCATION)           \
  X(LinkProgram, LINKPROGRAM)                         \
  X(ReadPixels, READPIXELS)                           \
  X(RenderbufferStorage, RENDERBUFFERSTORAGE)         \
  X(ShaderSource, SHADERSOURCE)                       \
  X(TexParameteri, TEXPARAMETERI)                     \
  X(TexStorage2D, TEXSTORAGE2D)                       \
  X(TexStorage3D, TEXSTORAGE3D)                       \
  X(TexSubImage2D, TEXSUBIMAGE2D)                     \
  X(TexSubImage3D, TEXSUBIMAGE3D)                     \
  X(Uniform1f, UNIFORM1F)                             \
  X(Uniform1i, UNIFORM1I)                             \
  X(Uniform2f, UNIFORM2F)                             \
  X(Uniform4f, UNIFORM4F)                             \
  X(UniformMatrix3fv, UNIFORMMATRIX3FV)               \
  X(UniformMatrix4fv, UNIFORMMATRIX4FV)               \
  X(UseProgram, USEPROGRAM)                           \
  X(VertexAttribPointer, VERTEXATTRIBPOINTER)         \
  X(Viewport, VIEWPORT)

struct Gl {
#define CTN_VR_GL_MEMBER(name, type) PFNGL##type##PROC name = nullptr;
  CTN_VR_GL_FUNCTIONS(CTN_VR_GL_MEMBER)
#undef CTN_VR_GL_MEMBER
};

}  // namespace ctn::vr::drawing
