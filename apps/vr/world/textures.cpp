#include "world/textures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "program/random.h"

namespace ctn::vr::world {
namespace {

constexpr std::uint64_t kTextureStream = 100;  // of random numbers: one a texture from here on
constexpr int kSide = Texture::kSide;

struct Colour {
  double red = 0.0;
  double green = 0.0;
  double blue = 0.0;
};
Colour operator*(double by, const Colour& colour) { return {by * colour.red, by * colour.green, by * colour.blue}; }
Colour grey(double level) { return {level, level, level}; }

// A picture that is being painted. What lies beyond an edge comes in at the opposite one, so that the texture repeats.
class Canvas {
 public:
  explicit Canvas(std::uint64_t seed, std::size_t texture) : draws_(seed, kTextureStream + texture) {
    texture_.rgb.resize(std::size_t{3} * kSide * kSide);
  }

  program::Draws& draws() { return draws_; }
  double some(double low, double high) { return draws_.between(low, high); }
  int some(int low, int high) { return draws_.between(low, high); }
  Colour some_colour(double low, double high) { return {some(low, high), some(low, high), some(low, high)}; }

  void rectangle(int left, int top, int width, int height, const Colour& colour) {
    for (int y = top; y < top + height; ++y) {
      for (int x = left; x < left + width; ++x) set(x, y, colour);
    }
  }
  void disc(int x0, int y0, int radius, const Colour& colour) {
    for (int y = -radius; y <= radius; ++y) {
      for (int x = -radius; x <= radius; ++x) {
        if (x * x + y * y <= radius * radius) set(x0 + x, y0 + y, colour);
      }
    }
  }
  void diamond(int x0, int y0, int radius, const Colour& colour) {
    for (int y = -radius; y <= radius; ++y) {
      for (int x = -radius; x <= radius; ++x) {
        if (std::abs(x) + std::abs(y) <= radius) set(x0 + x, y0 + y, colour);
      }
    }
  }
  // A right-angled triangle.
  void triangle(int left, int top, int side, const Colour& colour) {
    for (int y = 0; y < side; ++y) rectangle(left, top + y, y + 1, 1, colour);
  }
  // Lines of words, of letters that are little blocks.
  void text(int left, int top, int width, int height, int size, const Colour& colour) {
    for (int y = top; y + size <= top + height; y += size * 2) {
      const int end = left + some(width / 2, width);
      for (int x = left; x < end;) {
        const int word = some(2, 7) * size;
        for (int letter = 0; letter < word && x + letter + size < end; letter += size + std::max(1, size / 3)) {
          rectangle(x + letter, y + (some(0, 2) == 0 ? size / 2 : 0), size, size - (some(0, 2) == 0 ? size / 2 : 0),
                    colour);
        }
        x += word + 2 * size;
      }
    }
  }
  // Each pixel brighter or darker by up to `amount` of it.
  void roughen(double amount) {
    for (std::size_t i = 0; i < texture_.rgb.size(); i += 3) {
      const double by = 1.0 + some(-amount, amount);
      for (std::size_t j = 0; j < 3; ++j) texture_.rgb[i + j] = byte(by * texture_.rgb[i + j]);
    }
  }
  Texture take() { return std::move(texture_); }

 private:
  static std::uint8_t byte(double value) { return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0)); }
  void set(int x, int y, const Colour& colour) {
    const std::size_t at =
        3 * (static_cast<std::size_t>(y & (kSide - 1)) * kSide + static_cast<std::size_t>(x & (kSide - 1)));
    texture_.rgb[at] = byte(colour.red);
    texture_.rgb[at + 1] = byte(colour.green);
    texture_.rgb[at + 2] = byte(colour.blue);
  }

  Texture texture_;
  program::Draws draws_;
};

void paint_planks(Canvas& canvas) {
  constexpr int kPlank = 32;
  for (int row = 0; row < kSide / kPlank; ++row) {
    int left = canvas.some(0, kSide);
    for (int end = left + kSide; left < end;) {
      const int length = std::min(canvas.some(70, 150), end - left);
      const Colour wood = canvas.some(0.65, 1.15) * Colour{160, 115, 75};
      canvas.rectangle(left, row * kPlank, length, kPlank, wood);
      for (int grain = 0; grain < 9; ++grain) {
        canvas.rectangle(left + canvas.some(0, length / 2), row * kPlank + canvas.some(1, kPlank - 2),
                         canvas.some(10, length / 2), 1, canvas.some(0.7, 0.95) * wood);
      }
      if (canvas.some(0, 2) == 0) canvas.disc(left + length / 2, row * kPlank + canvas.some(6, 24), 3, 0.5 * wood);
      canvas.rectangle(left, row * kPlank, 2, kPlank, 0.35 * wood);
      left += length;
    }
    canvas.rectangle(0, row * kPlank, kSide, 2, {60, 40, 25});
  }
  canvas.roughen(0.05);
}

void paint_ceiling(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, grey(215));
  for (int i = 0; i < 700; ++i) {
    canvas.rectangle(canvas.some(0, kSide), canvas.some(0, kSide), canvas.some(1, 5), canvas.some(1, 4),
                     grey(canvas.some(120.0, 190.0)));
  }
  for (int line = 0; line < kSide; line += kSide / 2) {
    canvas.rectangle(line, 0, 4, kSide, grey(110));
    canvas.rectangle(0, line, kSide, 4, grey(110));
  }
}

void paint_bricks(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {190, 185, 175});
  constexpr int kRow = 16;
  constexpr int kBrick = 32;
  for (int row = 0; row < kSide / kRow; ++row) {
    for (int x = 0; x < kSide; x += kBrick) {
      canvas.rectangle(x + (row % 2) * kBrick / 2, row * kRow, kBrick - 2, kRow - 2,
                       canvas.some(0.55, 1.2) * Colour{150, canvas.some(65.0, 90.0), 60});
    }
  }
  canvas.roughen(0.08);
}

void paint_wallpaper(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {205, 200, 170});
  for (int i = 0; i < 90; ++i) {
    const int x = canvas.some(0, kSide);
    const int y = canvas.some(0, kSide);
    const Colour colour = canvas.some_colour(40, 170);
    const int size = canvas.some(4, 12);
    if (i % 3 == 0) {
      canvas.disc(x, y, size, colour);
      canvas.disc(x, y, size / 2, {225, 215, 150});
    } else {
      canvas.diamond(x, y, size, colour);
    }
  }
}

void paint_plaster(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {170, 185, 195});
  for (int i = 0; i < 60; ++i) {
    canvas.rectangle(canvas.some(0, kSide), canvas.some(0, kSide), canvas.some(8, 45), canvas.some(8, 45),
                     canvas.some(0.6, 1.25) * Colour{150, 165, 180});
  }
  canvas.roughen(0.04);
}

void paint_panels(Canvas& canvas) {
  constexpr int kPanel = 64;
  for (int y = 0; y < kSide; y += kPanel) {
    for (int x = 0; x < kSide; x += kPanel) {
      const Colour colour = canvas.some(0.55, 1.15) * Colour{185, 165, 140};
      canvas.rectangle(x, y, kPanel, kPanel, 0.45 * colour);
      canvas.rectangle(x + 3, y + 3, kPanel - 6, kPanel - 6, colour);
      const int inset = canvas.some(10, 22);
      canvas.rectangle(x + inset, y + inset, kPanel - 2 * inset, kPanel - 2 * inset, canvas.some(0.5, 1.3) * colour);
    }
  }
}

void paint_books(Canvas& canvas) {
  constexpr int kShelf = 64;
  for (int shelf = 0; shelf < kSide / kShelf; ++shelf) {
    canvas.rectangle(0, shelf * kShelf, kSide, kShelf, grey(35));
    for (int x = 0; x < kSide;) {
      const int width = canvas.some(6, 18);
      const int height = canvas.some(40, 56);
      const int top = shelf * kShelf + kShelf - 5 - height;
      const Colour cover = canvas.some_colour(40, 230);
      canvas.rectangle(x, top, width - 1, height, cover);
      canvas.rectangle(x + 1, top + canvas.some(4, 12), width - 3, canvas.some(3, 14), canvas.some_colour(20, 255));
      x += width;
    }
    canvas.rectangle(0, shelf * kShelf + kShelf - 5, kSide, 5, {120, 85, 50});
  }
}

void paint_fabric(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {95, 60, 70});
  for (int i = 0; i < kSide; i += 32) {
    canvas.rectangle(i, 0, 10, kSide, {130, 95, 90});
    canvas.rectangle(0, i, kSide, 10, {140, 105, 95});
  }
  for (int i = 0; i < 50; ++i) {
    canvas.diamond(canvas.some(0, kSide), canvas.some(0, kSide), canvas.some(3, 7), canvas.some_colour(120, 220));
  }
  canvas.roughen(0.1);
}

void paint_wood(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {175, 130, 85});
  for (int i = 0; i < 160; ++i) {
    canvas.rectangle(canvas.some(0, kSide), canvas.some(0, kSide), canvas.some(20, 140), canvas.some(1, 3),
                     canvas.some(0.6, 1.1) * Colour{165, 120, 75});
  }
  for (int i = 0; i < 14; ++i) {
    canvas.disc(canvas.some(0, kSide), canvas.some(0, kSide), canvas.some(2, 5), {90, 60, 35});
  }
}

void paint_rug(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {125, 40, 45});
  for (int ring = 0; ring < 5; ++ring) {
    const int at = 4 + ring * 9;
    canvas.rectangle(at, at, kSide - 2 * at, kSide - 2 * at, canvas.some_colour(30, 200));
  }
  for (int i = 0; i < 110; ++i) {
    const int x = canvas.some(55, kSide - 55);
    const int y = canvas.some(55, kSide - 55);
    canvas.diamond(x, y, canvas.some(3, 10), canvas.some_colour(30, 230));
  }
}

void paint_window(Canvas& canvas) {
  for (int y = 0; y < kSide; ++y) canvas.rectangle(0, y, kSide, 1, {150.0 + 0.3 * y, 190.0 + 0.2 * y, 240});
  for (int x = 0; x < kSide;) {
    const int width = canvas.some(25, 60);
    const int height = canvas.some(60, 190);
    const Colour house = canvas.some_colour(70, 170);
    canvas.rectangle(x, kSide - height, std::min(width, kSide - x), height, house);
    for (int y = kSide - height + 6; y < kSide - 8; y += 16) {
      for (int w = x + 4; w + 7 < std::min(x + width, kSide); w += 11) {
        canvas.rectangle(w, y, 7, 9, canvas.some(0, 1) == 0 ? Colour{240, 230, 160} : grey(45));
      }
    }
    x += width;
  }
  for (const int line : {0, kSide / 2 - 4, kSide - 8}) {
    canvas.rectangle(line, 0, 8, kSide, grey(235));
    canvas.rectangle(0, line, kSide, 8, grey(235));
  }
}

void paint_screen(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {20, 25, 40});
  canvas.rectangle(0, 0, kSide, 14, {70, 110, 170});
  canvas.text(10, 22, 150, 220, 5, {150, 220, 160});
  canvas.rectangle(175, 30, 70, 90, {200, 120, 60});
  canvas.triangle(180, 50, 60, {240, 230, 90});
  canvas.text(175, 135, 70, 110, 4, grey(210));
}

void paint_door(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {140, 95, 60});
  canvas.rectangle(0, 0, kSide, 8, {80, 50, 30});
  canvas.rectangle(0, 0, 10, kSide, {80, 50, 30});
  canvas.rectangle(kSide - 10, 0, 10, kSide, {80, 50, 30});
  for (const int x : {36, 140}) {
    for (const int y : {25, 150}) {
      canvas.rectangle(x, y, 80, y == 25 ? 100 : 85, {100, 65, 38});
      canvas.rectangle(x + 8, y + 8, 64, y == 25 ? 84 : 69, {165, 118, 78});
    }
  }
  canvas.rectangle(220, 132, 22, 8, grey(220));
  canvas.text(90, 40, 76, 30, 5, grey(240));
}

void paint_leaves(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, {25, 50, 25});
  for (int i = 0; i < 260; ++i) {
    const int x = canvas.some(0, kSide);
    const int y = canvas.some(0, kSide);
    const Colour leaf{canvas.some(30.0, 110.0), canvas.some(90.0, 210.0), canvas.some(20.0, 80.0)};
    if (i % 2 == 0) {
      canvas.triangle(x, y, canvas.some(8, 22), leaf);
    } else {
      canvas.diamond(x, y, canvas.some(5, 13), leaf);
    }
  }
}

void paint_poster(Canvas& canvas) {
  canvas.rectangle(0, 0, kSide, kSide, grey(30));
  canvas.rectangle(8, 8, kSide - 16, kSide - 16, canvas.some_colour(120, 250));
  for (int i = 0; i < 26; ++i) {
    const int size = canvas.some(10, 45);
    const int x = canvas.some(14, kSide - 16 - size);
    const int y = canvas.some(14, kSide - 80 - size);
    const Colour colour = canvas.some_colour(0, 255);
    switch (canvas.some(0, 3)) {
      case 0:
        canvas.rectangle(x, y, size, canvas.some(6, size), colour);
        break;
      case 1:
        canvas.disc(x + size / 2, y + size / 2, size / 2, colour);
        break;
      case 2:
        canvas.triangle(x, y, size, colour);
        break;
      default:
        canvas.diamond(x + size / 2, y + size / 2, size / 2, colour);
        break;
    }
  }
  canvas.text(20, kSide - 66, kSide - 40, 50, 6, grey(20));
}

}  // namespace

std::vector<Texture> textures(std::uint64_t seed) {
  constexpr std::array kPainters{&paint_planks, &paint_ceiling, &paint_bricks, &paint_wallpaper, &paint_plaster,
                                 &paint_panels, &paint_books,   &paint_fabric, &paint_wood,      &paint_rug,
                                 &paint_window, &paint_screen,  &paint_door,   &paint_leaves,    &paint_poster};
  std::vector<Texture> all;
  for (std::size_t i = 0; i < kTextures; ++i) {
    Canvas canvas(seed, i);
    kPainters[std::min(i, kPainters.size() - 1)](canvas);
    all.push_back(canvas.take());
  }
  return all;
}

}  // namespace ctn::vr::world
