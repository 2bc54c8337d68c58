// What bindgen cannot bind: Embree's header-only inline functions, and the trace calls, whose shape differs
// between Embree 3.13 (context argument) and 4.x (arguments structure). Both versions end in the same
// functions here, so that Rust sees one interface.

#include <stddef.h>

#if DRT_EMBREE_MAJOR >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#if RTC_VERSION_MAJOR >= 4

#define DRT_INTERSECT_SETUP(coherent)                                                     \
  struct RTCIntersectArguments arguments;                                                \
  rtcInitIntersectArguments(&arguments);                                                 \
  arguments.flags = (coherent) ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT; \
  arguments.feature_mask = RTC_FEATURE_FLAG_TRIANGLE

#define DRT_OCCLUDED_SETUP(coherent)                                                      \
  struct RTCOccludedArguments arguments;                                                 \
  rtcInitOccludedArguments(&arguments);                                                  \
  arguments.flags = (coherent) ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT; \
  arguments.feature_mask = RTC_FEATURE_FLAG_TRIANGLE

#define DRT_CALL(function, scene, rays) function((scene), (rays), &arguments)
#define DRT_CALL_PACKET(function, valid, scene, rays) function((valid), (scene), (rays), &arguments)

#else

#define DRT_INTERSECT_SETUP(coherent)      \
  struct RTCIntersectContext context;      \
  rtcInitIntersectContext(&context);       \
  context.flags = (coherent) ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT

#define DRT_OCCLUDED_SETUP(coherent) DRT_INTERSECT_SETUP(coherent)

#define DRT_CALL(function, scene, rays) function((scene), &context, (rays))
#define DRT_CALL_PACKET(function, valid, scene, rays) function((valid), (scene), &context, (rays))

#endif

void drt_rtc_intersect1(RTCScene scene, bool coherent, struct RTCRayHit *rays) {
  DRT_INTERSECT_SETUP(coherent);
  DRT_CALL(rtcIntersect1, scene, rays);
}

void drt_rtc_occluded1(RTCScene scene, bool coherent, struct RTCRay *rays) {
  DRT_OCCLUDED_SETUP(coherent);
  DRT_CALL(rtcOccluded1, scene, rays);
}

// What a program in C would do: the yardstick for drt's own calls.
void drt_rtc_intersect_each(RTCScene scene, struct RTCRayHit *rays, size_t count) {
  DRT_INTERSECT_SETUP(false);
  for (size_t i = 0; i < count; i++) DRT_CALL(rtcIntersect1, scene, rays + i);
}

void drt_rtc_occluded_each(RTCScene scene, struct RTCRay *rays, size_t count) {
  DRT_OCCLUDED_SETUP(false);
  for (size_t i = 0; i < count; i++) DRT_CALL(rtcOccluded1, scene, rays + i);
}

#define DRT_PACKET(width)                                                                                      \
  void drt_rtc_intersect##width(RTCScene scene, bool coherent, const int *valid, struct RTCRayHit##width *rays) { \
    DRT_INTERSECT_SETUP(coherent);                                                                             \
    DRT_CALL_PACKET(rtcIntersect##width, valid, scene, rays);                                                  \
  }                                                                                                            \
  void drt_rtc_occluded##width(RTCScene scene, bool coherent, const int *valid, struct RTCRay##width *rays) {   \
    DRT_OCCLUDED_SETUP(coherent);                                                                              \
    DRT_CALL_PACKET(rtcOccluded##width, valid, scene, rays);                                                   \
  }

DRT_PACKET(4)
DRT_PACKET(8)
DRT_PACKET(16)
