/* Eq. (8) is that of the measured rotors, beneath the functions of the vehicle. */
#define family_step library_step
#define family_rest library_rest
#define family_throttle_for library_throttle_for
