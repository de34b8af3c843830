//! part of touchref
