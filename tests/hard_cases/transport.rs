//! Light from bounce to bounce, against closed forms.
