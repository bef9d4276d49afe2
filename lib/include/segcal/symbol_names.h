/* Prefixes every public name with SEGCAL_RENAME, so that builds with different profiles can live in one program
   (the host tools do this). Include before anything else of segcal; define SEGCAL_RENAME=segcal_mcu_ for example. */
#ifndef SEGCAL_SYMBOL_NAMES_H
#define SEGCAL_SYMBOL_NAMES_H

#define SEGCAL_PASTE2(prefix, name) prefix##name
#define SEGCAL_PASTE(prefix, name) SEGCAL_PASTE2(prefix, name)
#define SEGCAL_NAME(name) SEGCAL_PASTE(SEGCAL_RENAME, name)

#define segcal_background SEGCAL_NAME(background)
#define segcal_calibrate SEGCAL_NAME(calibrate)
#define segcal_create SEGCAL_NAME(create)
#define segcal_flush SEGCAL_NAME(flush)
#define segcal_get_camera SEGCAL_NAME(get_camera)
#define segcal_get_counters SEGCAL_NAME(get_counters)
#define segcal_get_direction SEGCAL_NAME(get_direction)
#define segcal_get_imu_calibration SEGCAL_NAME(get_imu_calibration)
#define segcal_get_imu_residuals SEGCAL_NAME(get_imu_residuals)
#define segcal_get_filter_calibration SEGCAL_NAME(get_filter_calibration)
#define segcal_get_keyframes SEGCAL_NAME(get_keyframes)
#define segcal_get_point_residuals SEGCAL_NAME(get_point_residuals)
#define segcal_get_result SEGCAL_NAME(get_result)
#define segcal_get_segment SEGCAL_NAME(get_segment)
#define segcal_get_segment_directions SEGCAL_NAME(get_segment_directions)
#define segcal_get_state SEGCAL_NAME(get_state)
#define segcal_memory SEGCAL_NAME(memory)
#define segcal_new_session SEGCAL_NAME(new_session)
#define segcal_push_imu SEGCAL_NAME(push_imu)
#define segcal_push_keyframe SEGCAL_NAME(push_keyframe)
#define segcal_push_tracks SEGCAL_NAME(push_tracks)
#define segcal_storage_bytes SEGCAL_NAME(storage_bytes)
#define segcal_version SEGCAL_NAME(version)
#define segcal_camera_t SEGCAL_NAME(camera_t)
#define segcal_config_t SEGCAL_NAME(config_t)
#define segcal_counters_t SEGCAL_NAME(counters_t)
#define segcal_direction_t SEGCAL_NAME(direction_t)
#define segcal_imu_calibration_t SEGCAL_NAME(imu_calibration_t)
#define segcal_imu_residual_t SEGCAL_NAME(imu_residual_t)
#define segcal_imu_t SEGCAL_NAME(imu_t)
#define segcal_parameter_t SEGCAL_NAME(parameter_t)
#define segcal_point_residual_t SEGCAL_NAME(point_residual_t)
#define segcal_point_t SEGCAL_NAME(point_t)
#define segcal_result_t SEGCAL_NAME(result_t)
#define segcal_segment_t SEGCAL_NAME(segment_t)
#define segcal_state_t SEGCAL_NAME(state_t)
#define segcal_t SEGCAL_NAME(t)

#endif
