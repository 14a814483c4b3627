#include "scene.h"

#include <box2d/b2_distance.h>
#include <box2d/box2d.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "program/random.h"

namespace ctn::navigation::world {
namespace {

constexpr std::uint64_t kPhases = 1;  // stream of random numbers

float single(double value) { return static_cast<float>(value); }
b2Vec2 vector_of(Point point) { return {single(point.x), single(point.y)}; }
b2Transform placed(Point point, double heading) {
  b2Transform transform;
  transform.Set(vector_of(point), single(wrapped(heading)));
  return transform;
}

class NearestHit : public b2RayCastCallback {
 public:
  float ReportFixture(b2Fixture*, const b2Vec2&, const b2Vec2&, float fraction) override {
    nearest = std::min(nearest, fraction);
    return fraction;  // the ray ends there: what is beyond is of no interest
  }
  float nearest = 2.0F;
};

// Polygons without the skin that Box2D puts around them, so that distances are the true ones.
double between(const b2Shape& a, const b2Transform& a_at, const b2Shape& b, const b2Transform& b_at) {
  b2DistanceInput input;
  input.proxyA.Set(&a, 0);
  input.proxyB.Set(&b, 0);
  input.transformA = a_at;
  input.transformB = b_at;
  input.useRadii = false;
  b2SimplexCache cache;
  cache.count = 0;
  b2DistanceOutput output;
  b2Distance(&output, &cache, &input);
  return static_cast<double>(output.distance);
}

class NearestWall : public b2QueryCallback {
 public:
  NearestWall(const b2Shape& shape, const b2Transform& at, double limit) : nearest(limit), shape_(shape), at_(at) {}
  bool ReportFixture(b2Fixture* fixture) override {
    nearest = std::min(nearest, between(*fixture->GetShape(), fixture->GetBody()->GetTransform(), shape_, at_));
    return true;
  }
  double nearest;

 private:
  const b2Shape& shape_;
  const b2Transform& at_;
};

b2PolygonShape box_shape(double length, double width) {
  b2PolygonShape box;
  box.SetAsBox(single(length / 2.0), single(width / 2.0));
  return box;
}

std::unique_ptr<b2Shape> shape_of(const MoverSpec& spec) {
  if (spec.radius <= 0.0) return std::make_unique<b2PolygonShape>(box_shape(spec.length, spec.width));
  auto circle = std::make_unique<b2CircleShape>();
  circle->m_radius = single(spec.radius);
  return circle;
}

}  // namespace

struct Scene::Shapes {
  b2World walls{b2Vec2(0.0F, 0.0F)};
  std::vector<std::unique_ptr<b2Shape>> movers;
};

Scene::Scene(const WorldFile& world, std::uint64_t seed) : shapes_(std::make_unique<Shapes>()) {
  const b2BodyDef body_definition;
  b2Body* body = shapes_->walls.CreateBody(&body_definition);
  for (const Segment& wall : world.walls) {
    b2EdgeShape edge;
    edge.SetTwoSided(vector_of(wall.from), vector_of(wall.to));
    body->CreateFixture(&edge, 0.0F);
  }
  const program::Noise phases(seed, kPhases);
  for (const MoverSpec& mover : world.movers) {
    movers_.emplace_back(mover, phases.uniform(movers_.size()));
    shapes_->movers.push_back(shape_of(mover));
  }
}

Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

void Scene::cast(const Pose& from, double time, double field, double range, std::span<float> rays) const {
  const auto count = static_cast<double>(rays.size());
  const double step = rays.size() > 1 ? field / (count - 1.0) : 0.0;
  const double first = rays.size() > 1 ? -field / 2.0 : 0.0;
  const auto end_of = [&](std::size_t ray) {
    const double angle = from.heading + first + step * static_cast<double>(ray);
    return vector_of(position(from) + Point{std::cos(angle), std::sin(angle)} * range);
  };
  const b2Vec2 begin = vector_of(position(from));
  for (std::size_t ray = 0; ray < rays.size(); ++ray) {
    NearestHit hit;
    shapes_->walls.RayCast(&hit, begin, end_of(ray));
    rays[ray] = hit.nearest <= 1.0F ? hit.nearest * single(range) : std::numeric_limits<float>::infinity();
  }
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    const MoverSpec& spec = movers_[i].spec();
    const Point at = movers_[i].at(time);
    const double away = distance(at, position(from));
    if (away - spec.reach() > range) continue;
    // Tries only the rays that can meet it.
    std::size_t low = 0;
    std::size_t high = rays.size();
    if (away > spec.reach() && step > 0.0) {
      const double half = std::asin(spec.reach() / away);
      const double middle = wrapped(std::atan2(at.y - from.y, at.x - from.x) - from.heading);
      const auto ray_at = [&](double angle) { return std::clamp((angle - first) / step, 0.0, count); };
      low = static_cast<std::size_t>(std::floor(ray_at(middle - half)));
      high = static_cast<std::size_t>(std::floor(std::min(count, ray_at(middle + half) + 1.0)));
      // A wide field may see it across the heading's back.
      if (field / 2.0 + half >= std::numbers::pi) {
        low = 0;
        high = rays.size();
      }
    }
    const b2Transform transform = placed(at, spec.heading);
    for (std::size_t ray = low; ray < high; ++ray) {
      const b2RayCastInput input{begin, end_of(ray), 1.0F};
      b2RayCastOutput output;
      if (shapes_->movers[i]->RayCast(&output, input, transform, 0)) {
        rays[ray] = std::min(rays[ray], output.fraction * single(range));
      }
    }
  }
}

double Scene::to_walls(const Pose& pose, double size, double limit) const {
  const b2PolygonShape square = box_shape(size, size);
  const b2Transform at = placed(position(pose), pose.heading);
  NearestWall nearest(square, at, limit);
  const double reach = size / std::numbers::sqrt2 + limit;
  b2AABB around;
  around.lowerBound = vector_of(position(pose) - Point{reach, reach});
  around.upperBound = vector_of(position(pose) + Point{reach, reach});
  shapes_->walls.QueryAABB(&nearest, around);
  return nearest.nearest;
}

double Scene::to_mover(std::size_t mover, const Pose& pose, double size, double time) const {
  const MoverSpec& spec = movers_[mover].spec();
  const b2PolygonShape square = box_shape(size, size);
  const double apart = between(*shapes_->movers[mover], placed(movers_[mover].at(time), spec.heading), square,
                               placed(position(pose), pose.heading));
  return std::max(0.0, apart - spec.radius);
}

}  // namespace ctn::navigation::world
