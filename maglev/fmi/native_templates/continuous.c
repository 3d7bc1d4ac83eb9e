static const uint32_t STATES[] = {@STATES@};
static const uint32_t RATES[] = {@RATES@};
static const double NOMINALS[] = {@NOMINALS@};
static const uint32_t INDICATORS[] = {@INDICATORS@};

static const struct Continuous CONTINUOUS = {
    .states = STATES,
    .rates = RATES,
    .nominals = NOMINALS,
    .state_count = sizeof STATES / sizeof *STATES,
    .indicators = INDICATORS,
    .indicator_count = sizeof INDICATORS / sizeof *INDICATORS,
    .derive = derive_block,
    .settle = settle_block,
    .differentiate = differentiate_block,
    .differentiate_start = differentiate_start_block,
    .differentiate_measurement = differentiate_measurement_block,
};

